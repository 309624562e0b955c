"""What passes between the parts of an evaluation: a clip, and what an engine made of it."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import msgspec

Kind = Literal["command", "near-miss", "talk", "noise", "long"]

BETWEEN_COMMANDS = " | "
"""Stands between the commands in the text of a `long` recording."""


class Clip(msgspec.Struct, frozen=True):
    """A recording with a known text.

    Attributes:
        set: the manifest it comes from.
        file: its path as the manifest has it; with `set` this is its name in reports.
        path: where it is.
        text: what is said in it, lower case; the commands of a `long` one with ` | ` between them.
        speaker: who says it; the file itself if the manifest does not know.
        kind: `command` is one command; `long` is several; the others should move nothing:
            `near-miss` is speech like a command, `talk` running speech, `noise` no speech.
        condition: a group of speakers or recordings that is scored by itself.
    """

    set: str
    file: str
    path: Path
    text: str
    speaker: str
    kind: Kind
    condition: str


class Understood(msgspec.Struct, frozen=True):
    """What an engine heard in a stretch of speech.

    Attributes:
        text: the words, lower case; empty if it fits no command.
        confidence: how sure it is, 0 to 1.
        accepted: whether it would be obeyed.
    """

    text: str
    confidence: float
    accepted: bool


class Result(msgspec.Struct, frozen=True):
    """What an engine made of a clip.

    Attributes:
        set: as in `Clip`, like the next five.
        snr: how much louder the speech is than the noise mixed into it, dB; None without noise.
        heard: the utterances in their order.
        seconds: how long the clip is, s.
        cpu: processor time that recognising took, without loading the engine, s.
        error: why the clip could not be read or recognised; None if it was.
    """

    set: str
    file: str
    text: str
    speaker: str
    kind: Kind
    condition: str
    snr: float | None = None
    heard: tuple[Understood, ...] = ()
    seconds: float = 0.0
    cpu: float = 0.0
    error: str | None = None

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
        """Whether exactly what was said was heard: one utterance for each command."""
        return self.texts == self.text.split(BETWEEN_COMMANDS)

    @property
    def is_right_and_accepted(self) -> bool:
        """Whether exactly what was said was heard, and all of it would be obeyed."""
        return self.is_right and self.obeyed == self.texts

    @property
    def is_wrongly_obeyed(self) -> bool:
        """Whether something that was not said would be obeyed."""
        said = self.text.split(BETWEEN_COMMANDS) if self.kind in ("command", "long") else []
        return any(text not in said for text in self.obeyed)

    @property
    def is_refused(self) -> bool:
        """Whether something was heard and none of it would be obeyed."""
        return bool(self.texts) and not self.obeyed
