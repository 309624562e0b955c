"""Who says the robot's replies: voz itself, or whoever listens on `robotsound`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from voz.config import Speech
from voz.events import Event, Reply
from voz.pipeline import replies_to
from voz.ros1.parameters import choice
from voz.speech.speaker import Speaker


@contextmanager
def replies(settings: Speech) -> Iterator[Callable[[Event], None]]:
    """A receiver that lets the replies be said, by `~sound`: `voz`, `ros` or `none`.

    Args:
        settings: whose voice, and whether at all.
    """
    sound = choice("sound", ("voz", "ros", "none")) if settings.enabled else "none"
    if sound == "voz":
        with Speaker(settings.voice) as speaker:
            yield replies_to(speaker)
    elif sound == "ros":
        yield _replies_on_robotsound(settings.voice)
    else:
        yield lambda event: None


def _replies_on_robotsound(voice: str) -> Callable[[Event], None]:
    from rospy import Publisher

    from voz.ros1.sound_request import ONCE, SAY, TOPIC, sound_request

    kind = sound_request()
    publisher = Publisher(TOPIC, kind, queue_size=10)

    def receive(event: Event) -> None:
        if isinstance(event, Reply):
            publisher.publish(kind(SAY, ONCE, 1.0, event.text, f"voice_{voice}"))

    return receive
