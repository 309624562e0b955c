"""What is known of a recording once it is decoded: a row for each utterance, or one that says why.

Every recording has a row at least, so that results can be joined to files.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import msgspec

from voz.apps.batch.stamps import Stamp
from voz.events import Reason, Utterance


class UtteranceRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """An utterance in a recording.

    Attributes:
        file: the recording.
        start: where the speech begins in it, s.
        end: where the speech ends in it, s.
        text: the sentence heard; empty if none fits.
        confidence: how sure it is, 0 to 1.
        accepted: whether it was recognized surely enough.
        reason: why not, if it would not.
        between: the two commands that it may be, if that is the reason.
        score: as in `Utterance`, like those that follow.
    """

    file: str
    start: float
    end: float
    text: str
    confidence: float
    accepted: bool
    reason: Reason | None = None
    between: tuple[str, str] | None = None
    score: float | None = None
    next_best: str | None = None
    command: str | None = None
    slots: Mapping[str, str | int | float] = {}


class SilentRow(msgspec.Struct, frozen=True):
    """A recording in which nothing was said.

    Attributes:
        file: the recording.
        seconds: how long it is, s.
    """

    file: str
    seconds: float


class ErrorRow(msgspec.Struct, frozen=True):
    """A recording that could not be read, or not to its end."""

    file: str
    error: str


Row: TypeAlias = UtteranceRow | SilentRow | ErrorRow


class Outcome(msgspec.Struct, frozen=True):
    """All that is known of one recording.

    Attributes:
        rows: one at least; an error is the last one.
        seconds: how much of it was heard, s.
        cpu: processor time that took, s.
        stamp: what the recording was like; None if that is not known.
    """

    rows: tuple[Row, ...]
    seconds: float = 0.0
    cpu: float = 0.0
    stamp: Stamp | None = None

    @property
    def failed(self) -> bool:
        """Whether it was not heard to its end."""
        return isinstance(self.rows[-1], ErrorRow)


def failed_outcome(file: str, error: str, stamp: Stamp | None = None) -> Outcome:
    """The outcome for a recording that gave nothing but an error."""
    return Outcome((ErrorRow(file, error),), stamp=stamp)


def make_outcome(file: str, heard: tuple[Row, ...], seconds: float, cpu: float) -> Outcome:
    """The outcome for a recording, also for one with nothing in it."""
    return Outcome(heard or (SilentRow(file, round(seconds, 3)),), round(seconds, 3), round(cpu, 4))


def utterance_row(heard: Utterance, file: str) -> UtteranceRow:
    """What was heard, as a row."""
    return UtteranceRow(
        file,
        heard.start,
        heard.end,
        heard.text,
        heard.confidence,
        heard.accepted,
        heard.reason,
        heard.between,
        heard.score,
        heard.next_best,
        heard.command,
        heard.slots,
    )


def parse_row(row: Mapping[str, object]) -> Row:
    """Turn what was read from JSON into the kind of row that it is."""
    if "error" in row:
        return msgspec.convert(row, ErrorRow)
    if "seconds" in row:
        return msgspec.convert(row, SilentRow)
    return msgspec.convert(row, UtteranceRow)
