"""Who says the robot's replies: voz itself, or whoever listens on `robotsound`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

from voz.audio.mixer import Mixer
from voz.config import Speech
from voz.control.controller import REPLIES
from voz.events import Event, Receiver, Reply
from voz.pipeline import replies_to
from voz.ros1.parameters import choice
from voz.speech.speaker import Speaker


class Replies(NamedTuple):
    """How the replies are said.

    Attributes:
        receive: says the replies among the events.
        problems: tells what went wrong since the last call.
        loudspeaker: what this process gives out, if it does.
    """

    receive: Receiver
    problems: Callable[[], list[str]] = list
    loudspeaker: Mixer | None = None


@contextmanager
def replies(settings: Speech) -> Iterator[Replies]:
    """Let the replies be said, by `~sound`: `voz`, `ros` or `none`.

    Args:
        settings: whose voice, and whether at all.
    """
    sound = choice("sound", ("voz", "ros", "none")) if settings.enabled else "none"
    if sound == "voz":
        with Speaker(settings.voice, REPLIES) as speaker:
            yield Replies(replies_to(speaker), speaker.drain_warnings, speaker.mixer)
    elif sound == "ros":
        yield Replies(_replies_on_robotsound(settings.voice))
    else:
        yield Replies(lambda event: None)


def _replies_on_robotsound(voice: str) -> Receiver:
    from rospy import Publisher

    from voz.ros1.sound_request import ONCE, SAY, TOPIC, sound_request

    kind = sound_request()
    publisher = Publisher(TOPIC, kind, queue_size=10)

    def receive(event: Event) -> None:
        if isinstance(event, Reply):
            publisher.publish(kind(SAY, ONCE, 1.0, event.text, f"voice_{voice}"))

    return receive
