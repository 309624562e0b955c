"""What passes between the parts of an evaluation."""

from __future__ import annotations

from typing import Literal

import msgspec

from voz.apps.recordings.manifest import BETWEEN_COMMANDS, Clip, Kind

OUT_OF_NOTHING = "out-of-nothing"
"""The kind of the parts of a stream where nobody said anything."""

ScoredKind = Literal[Kind, "out-of-nothing"]


class Understood(msgspec.Struct, frozen=True):
    """What an engine heard in a stretch of speech."""

    text: str  # lower case; empty if it fits no command
    confidence: float  # 0 to 1
    accepted: bool
    start: float = 0.0  # s
    end: float = 0.0  # s


class Result(msgspec.Struct, frozen=True):
    """What an engine made of a clip."""

    set: str  # as in `Clip`, like the next five, `start` and `end`
    file: str
    text: str
    speaker: str
    kind: ScoredKind
    condition: str
    snr: float | None = None  # speech to noise, dB; None without noise
    heard: tuple[Understood, ...] = ()  # in their order
    seconds: float = 0.0  # length of the clip
    cpu: float = 0.0  # processor time, s, without loading the engine; of a stream, the clip's part
    error: str | None = None  # why it could not be read or recognized
    noise: str = ""  # name of the noise; empty without
    start: float | None = None
    end: float | None = None

    @property
    def said(self) -> list[str]:
        """What was said, one text for each command."""
        return self.text.split(BETWEEN_COMMANDS)

    @property
    def texts(self) -> list[str]:
        """What was heard, without utterances that fit no command."""
        return [utterance.text for utterance in self.heard if utterance.text]

    @property
    def obeyed(self) -> list[str]:
        """What would be obeyed."""
        return [utterance.text for utterance in self.heard if utterance.accepted]

    @property
    def is_right(self) -> bool:
        """Whether exactly what was said was heard: one utterance for each command.

        Refused utterances beside accepted ones do not count.
        """
        return self.said in (self.texts, self.obeyed)

    @property
    def is_right_and_accepted(self) -> bool:
        """Whether exactly what was said would be obeyed."""
        return self.said == self.obeyed

    @property
    def is_wrongly_obeyed(self) -> bool:
        """Whether something that was not said would be obeyed."""
        said = self.said if self.kind in ("command", "long") else []
        return any(text not in said for text in self.obeyed)

    @property
    def is_refused(self) -> bool:
        """Whether something was heard and none of it would be obeyed."""
        return bool(self.texts) and not self.obeyed


def empty_result(clip: Clip) -> Result:
    """The result of a clip before it is heard."""
    said = (clip.set, clip.file, clip.text, clip.speaker, clip.kind, clip.condition)
    return Result(*said, start=clip.start, end=clip.end)
