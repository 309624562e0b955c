"""What passes between the parts of an evaluation: a clip, and what an engine made of it."""

from __future__ import annotations

from typing import Literal

import msgspec

from voz.apps.recordings.clips import BETWEEN_COMMANDS, Clip, Kind

OUT_OF_NOTHING = "out-of-nothing"
"""What is left of a stream: where nobody said anything."""

ScoredKind = Literal[Kind, "out-of-nothing"]
"""What is scored: what a manifest lists, and what is left."""


class Understood(msgspec.Struct, frozen=True):
    """What an engine heard in a stretch of speech.

    Attributes:
        text: the words, lower case; empty if it fits no command.
        confidence: how sure it is, 0 to 1.
        accepted: whether it would be obeyed.
        start: where it begins in what was heard, s; 0 in results that an older voz kept.
        end: where it ends there, s.
    """

    text: str
    confidence: float
    accepted: bool
    start: float = 0.0
    end: float = 0.0


class Result(msgspec.Struct, frozen=True):
    """What an engine made of a clip.

    Attributes:
        set: as in `Clip`, like the next five, and `start` and `end`.
        snr: how much louder the speech is than the noise mixed into it, dB; None without noise.
        heard: the utterances in their order.
        seconds: how long the clip is, s.
        cpu: processor time that recognizing took, without loading the engine, s; of a stream, a
            clip's part of it.
        error: why the clip could not be read or recognized; None if it was.
        noise: the recording of noise that was mixed in; empty without noise.
    """

    set: str
    file: str
    text: str
    speaker: str
    kind: ScoredKind
    condition: str
    snr: float | None = None
    heard: tuple[Understood, ...] = ()
    seconds: float = 0.0
    cpu: float = 0.0
    error: str | None = None
    noise: str = ""
    start: float | None = None
    end: float | None = None

    @property
    def said(self) -> list[str]:
        """What was said, one text for each command."""
        return self.text.split(BETWEEN_COMMANDS)

    @property
    def texts(self) -> list[str]:
        """What was heard; utterances that fit no command move nothing and do not count."""
        return [utterance.text for utterance in self.heard if utterance.text]

    @property
    def obeyed(self) -> list[str]:
        """What would be obeyed."""
        return [utterance.text for utterance in self.heard if utterance.accepted]

    @property
    def is_right(self) -> bool:
        """Whether exactly what was said was heard: one utterance for each command.

        What is refused beside what would be obeyed moves nothing, and does not count.
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
    """Begin the result of a clip, before it is heard."""
    said = (clip.set, clip.file, clip.text, clip.speaker, clip.kind, clip.condition)
    return Result(*said, start=clip.start, end=clip.end)
