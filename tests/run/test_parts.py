"""What makes the robot speak, and what silences it."""

from __future__ import annotations

from typing import cast

import pytest

from voz.events import Event, Partial, Play, Reply, Utterance
from voz.run.parts import speaker_receiver
from voz.speech.reply_speaker import ReplySpeaker


class Voice:
    """A speaker that keeps what it is to do."""

    def __init__(self, barge_in: bool) -> None:
        self.mixer = self
        self.barge_in = barge_in
        self.done: list[str] = []

    def say(self, text: str) -> None:
        self.done.append(f"say {text}")

    def play(self, sound: str) -> None:
        self.done.append(f"play {sound}")

    def interrupt(self) -> None:
        self.done.append("fall silent")


def done(event: Event, barge_in: bool = False, interruptible: bool = True) -> list[str]:
    voice = Voice(barge_in)
    speaker_receiver(cast(ReplySpeaker, voice), {"stop", "halt"}, interruptible)(event)
    return voice.done


def utterance(text: str, obeyed: bool) -> Utterance:
    return Utterance(2.0, text, 1.0, True, 1.0, 1.8, "microphone", obeyed=obeyed)


def test_replies_are_said_and_sounds_played() -> None:
    assert done(Reply(1.0, "hello")) == ["say hello"]
    assert done(Play(1.0, "beep.wav")) == ["play beep.wav"]


@pytest.mark.parametrize(
    ("event", "always", "with_barge_in"),
    [
        (Partial(1.0, "please stop", 0.6, "stop"), True, True),
        (Partial(1.0, "go forward", 0.9), False, False),
        (utterance("halt", obeyed=True), True, True),
        (utterance("go forward", obeyed=True), False, True),
        (utterance("stop", obeyed=False), False, False),
        (utterance("go forward", obeyed=False), False, False),
    ],
)
def test_what_stops_silences_it_and_with_barge_in_every_command_that_is_obeyed(
    event: Event, always: bool, with_barge_in: bool
) -> None:
    assert (done(event) == ["fall silent"]) is always
    assert (done(event, barge_in=True) == ["fall silent"]) is with_barge_in
    assert done(event, barge_in=True, interruptible=False) == []
