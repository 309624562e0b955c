"""A recording whose text is known."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import msgspec

Kind = Literal["command", "near-miss", "talk", "noise", "long"]

BETWEEN_COMMANDS = " | "
"""Stands between the commands in the text of a `long` recording."""


class Clip(msgspec.Struct, frozen=True):
    """A recording with a known text, or a stretch of one.

    Attributes:
        set: the manifest it comes from.
        file: its path as the manifest has it; with `set` this is its name in reports.
        path: where it is.
        text: what is said in it, lower case; the commands of a `long` one with ` | ` between them.
        speaker: who says it; the file itself if the manifest does not know.
        kind: `command` is one command; `long` is several; the others should move nothing:
            `near-miss` is speech like a command, `talk` running speech, `noise` no speech.
        condition: a group of speakers or recordings that is scored by itself.
        start: where it begins in a stream that goes on before and after it, s; None if it is all
            of its recording.
        end: where it ends there, s.
    """

    set: str
    file: str
    path: Path
    text: str
    speaker: str
    kind: Kind
    condition: str
    start: float | None = None
    end: float | None = None
