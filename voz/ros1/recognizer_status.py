"""The message on `trouble`: why a recognizer hears nothing."""

from __future__ import annotations

from dataclasses import dataclass

from voz.hearing.sound_watch import ONLY_SILENCE


@dataclass(frozen=True)
class RecognizerStatus:
    """Whether a recognizer hears.

    Attributes:
        problem: why it hears nothing; empty if all is well.
        only_silence: whether its microphone gives only zeros, which matters to a moving robot.
    """

    problem: str = ""
    only_silence: bool = False

    @property
    def text(self) -> str:
        """The message; another recognizer may publish any other text as a problem."""
        return self.problem or (ONLY_SILENCE if self.only_silence else "")


def parse_status(text: str) -> RecognizerStatus:
    """Read a message."""
    silent = text == ONLY_SILENCE
    return RecognizerStatus("" if silent else text, silent)
