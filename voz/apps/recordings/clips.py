"""A recording whose text is known."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import msgspec

Kind = Literal["command", "near-miss", "talk", "noise", "long"]

BETWEEN_COMMANDS = " | "
"""Separates the commands in the text of a `long` recording."""


class Clip(msgspec.Struct, frozen=True):
    """A recording with a known text, or a stretch of one."""

    set: str  # name of the manifest
    file: str  # path as in the manifest; with `set` the name in reports
    path: Path
    text: str  # lower case; the commands of a `long` one with ` | ` between them
    speaker: str  # the file itself if the manifest has none
    # one `command` or several (`long`); `near-miss`, `talk` and `noise` should move nothing
    kind: Kind
    condition: str  # a group of recordings that is scored by itself
    start: float | None = None  # in a stream, s; None if it is a whole recording
    end: float | None = None  # s
