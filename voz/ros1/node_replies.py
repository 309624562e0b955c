"""The robot's replies and sounds: played by voz, or by a node that reads `robotsound`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from msgspec.structs import replace

from voz.audio.playback.mixer import Mixer
from voz.control.table import CommandTable
from voz.events import Event, Play, Receiver, Reply
from voz.ros1.parameters import choice
from voz.run.session import interruption_receivers, open_speaker, speech_receivers
from voz.settings import Speech


@dataclass(frozen=True)
class Replies:
    """Receivers that play replies and sounds, and the loudspeaker of this process if it does."""

    receivers: list[Receiver]
    loudspeaker: Mixer | None = None


@contextmanager
def replies(
    settings: Speech, table: CommandTable, warn: Callable[[str], None]
) -> Iterator[Replies]:
    """Let the replies be said, by `~sound`: `voz`, `ros` or `none`; render the known ones first."""
    sound = choice("sound", ("voz", "ros", "none")) if settings.enabled else "none"
    if sound == "ros":
        yield Replies([_replies_on_robotsound(settings.voice)])
        return
    with open_speaker(replace(settings, enabled=sound == "voz"), table.replies, warn) as speaker:
        receivers = [*interruption_receivers(speaker, table.halts), *speech_receivers(speaker)]
        yield Replies(receivers, speaker.mixer if speaker else None)


def _replies_on_robotsound(voice: str) -> Receiver:
    from rospy import Publisher

    from voz.ros1.sound_request import ONCE, PLAY_FILE, SAY, TOPIC, sound_request
    from voz.speech.builtin_sounds import BuiltinSound

    kind = sound_request()
    publisher = Publisher(TOPIC, kind, queue_size=10)
    builtin = {sound.title: int(sound) for sound in BuiltinSound}

    def receive(event: Event) -> None:
        if isinstance(event, Reply):
            publisher.publish(kind(SAY, ONCE, 1.0, event.text, f"voice_{voice}"))
        elif isinstance(event, Play) and event.sound in builtin:
            publisher.publish(kind(builtin[event.sound], ONCE, 1.0, "", ""))
        elif isinstance(event, Play):
            publisher.publish(kind(PLAY_FILE, ONCE, 1.0, str(Path(event.sound).resolve()), ""))

    return receive
