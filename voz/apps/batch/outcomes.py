"""The outcome of decoding a recording: rows, one at least, so that results can be joined to files.

There is a row for each utterance, or one that says that there was none, or why.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import msgspec

from voz.apps.batch.stamps import Stamp
from voz.events import Reason, Utterance


class UtteranceRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """An utterance in a recording."""

    file: str
    start: float  # s
    end: float  # s
    text: str  # empty if no sentence fits
    confidence: float  # 0 to 1
    accepted: bool
    reason: Reason | None = None  # why it was not accepted
    between: tuple[str, str] | None = None  # the two commands that it may be, if that is the reason
    score: float | None = None  # as in `Utterance`, like those that follow
    next_best: str | None = None
    command: str | None = None
    slots: Mapping[str, str | int | float] = {}


class SilentRow(msgspec.Struct, frozen=True):
    """A recording in which nothing was said."""

    file: str
    seconds: float  # length of the recording, s


class ErrorRow(msgspec.Struct, frozen=True):
    """A recording that could not be read, or not to its end."""

    file: str
    error: str


Row: TypeAlias = UtteranceRow | SilentRow | ErrorRow


class Outcome(msgspec.Struct, frozen=True):
    """All that is known of one recording."""

    rows: tuple[Row, ...]  # one at least; an error is the last one
    seconds: float = 0.0  # how much was heard, s
    cpu: float = 0.0  # processor time, s
    stamp: Stamp | None = None  # None if it is not known

    @property
    def failed(self) -> bool:
        """Whether it was not heard to its end."""
        return isinstance(self.rows[-1], ErrorRow)


def failed_outcome(file: str, error: str, stamp: Stamp | None = None) -> Outcome:
    """The outcome of a recording that gave nothing but an error."""
    return Outcome((ErrorRow(file, error),), stamp=stamp)


def make_outcome(file: str, heard: tuple[Row, ...], seconds: float, cpu: float) -> Outcome:
    """The outcome of a recording, rounded, also of a silent one."""
    return Outcome(heard or (SilentRow(file, round(seconds, 3)),), round(seconds, 3), round(cpu, 4))


def utterance_row(heard: Utterance, file: str) -> UtteranceRow:
    """The row of an utterance in a recording."""
    names = UtteranceRow.__struct_fields__[1:]
    return UtteranceRow(file, *(getattr(heard, name) for name in names))


def row_type(fields: Mapping[str, object]) -> type[Row]:
    """Return the type of a row in a file, which has no tag, by a field that no other type has."""
    if "error" in fields:
        return ErrorRow
    return SilentRow if "seconds" in fields else UtteranceRow


def parse_row(fields: Mapping[str, object]) -> Row:
    """Make a row of its fields in a file."""
    return msgspec.convert(fields, row_type(fields))
