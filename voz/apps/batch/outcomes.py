"""The outcome of decoding a recording: rows, one at least, so that results can be joined to files.

There is a row for each utterance, or one that says that there was none, or why. Pure.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import msgspec
from msgspec.structs import replace

from voz.apps.batch.stamps import Stamp
from voz.events import Alternative, Reason, SpokenWord, Utterance, to_json

COLUMNS = (
    "file",
    "start",
    "end",
    "text",
    "confidence",
    "accepted",
    "reason",
    "between",
    "score",
    "next_best",
    "command",
    "slots",
    "seconds",
    "error",
)
"""Columns of all outputs: one for each field of all types of rows, but details."""

DETAIL_COLUMNS = ("words", "best")
"""Columns that follow these if they are asked for."""

HEADER_COLUMN = "header"
"""The last column: in the first row what the output was made by, in the others nothing."""

MANIFEST_PREFIX = "manifest_"
"""Put before the names of a manifest's columns that are the names of others, as `text`."""

ManifestFields: TypeAlias = Mapping[str, str]
"""What a manifest says of a recording, by the columns of outputs; without empty fields."""


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
    slots: Mapping[str, bool | str | int | float] = {}
    words: tuple[SpokenWord, ...] = ()
    best: tuple[Alternative, ...] = ()
    manifest: ManifestFields = {}


class SilentRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """A recording in which nothing was said."""

    file: str
    seconds: float  # length of the recording, s
    manifest: ManifestFields = {}


class ErrorRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """A recording that could not be read, or not to its end."""

    file: str
    error: str
    manifest: ManifestFields = {}


Row: TypeAlias = UtteranceRow | SilentRow | ErrorRow


class Outcome(msgspec.Struct, frozen=True):
    """All that is known of one recording."""

    rows: tuple[Row, ...]  # one at least; an error is the last one
    seconds: float = 0.0  # how much was heard, s
    cpu: float = 0.0  # processor time, s
    stamp: Stamp | None = None  # None if it is not known
    warnings: tuple[str, ...] = ()  # of what was read otherwise than it stands there

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
    names = UtteranceRow.__struct_fields__[1:-1]
    return UtteranceRow(file, *(getattr(heard, name) for name in names))


def utterance_of(row: UtteranceRow) -> Utterance:
    """The utterance of a row; it is not known any more when it was decided."""
    fields = {name: getattr(row, name) for name in UtteranceRow.__struct_fields__[1:-1]}
    return Utterance(t=row.end, source=row.file, **fields)


def column_name(name: str) -> str:
    """The column of an output in which a column of a manifest is."""
    taken = (*COLUMNS, *DETAIL_COLUMNS, HEADER_COLUMN)
    return f"{MANIFEST_PREFIX}{name}" if name in taken else name


def with_manifest(rows: Iterable[Row], manifest: ManifestFields) -> Iterator[Row]:
    """Put beside each row what a manifest says of its recording."""
    return (replace(row, manifest=manifest) for row in rows)


def row_fields(row: Row) -> dict[str, Any]:
    """The fields of a row by their columns; those without a value are left out."""
    fields = json.loads(to_json(row))
    manifest = fields.pop("manifest", {})
    return {**fields, **manifest}


def row_type(fields: Mapping[str, object]) -> type[Row]:
    """Return the type of a row in a file, which has no tag, by a field that no other type has."""
    if "error" in fields:
        return ErrorRow
    return SilentRow if "seconds" in fields else UtteranceRow


def parse_row(fields: Mapping[str, object]) -> Row:
    """Make a row of its fields in a file."""
    return msgspec.convert(fields, row_type(fields))


@dataclass
class Totals:
    """What outcomes add up to."""

    files: int = 0  # recordings
    failed: int = 0  # recordings that could not be read to their end
    silent: int = 0  # recordings with nothing in them
    utterances: int = 0
    accepted: int = 0  # utterances
    seconds: float = 0.0  # how much was heard, s
    cpu: float = 0.0  # processor time, s

    def add(self, outcome: Outcome) -> None:
        """Count one more recording."""
        heard = [row for row in outcome.rows if isinstance(row, UtteranceRow)]
        self.files += 1
        self.failed += outcome.failed
        self.silent += isinstance(outcome.rows[0], SilentRow)
        self.utterances += len(heard)
        self.accepted += sum(row.accepted for row in heard)
        self.seconds += outcome.seconds
        self.cpu += outcome.cpu

    def lines(self, took: float) -> list[str]:
        """Write it in words; `took` is the duration of the run, s."""
        hours = self.seconds / 3600
        each = f", {hours / (self.cpu / 3600):.0f} hours of sound per core-hour" if self.cpu else ""
        return [
            f"{self.files:,} recordings, {hours:.2f} h of sound in {took:.0f} s{each}",
            f"{self.utterances:,} utterances, {self.accepted:,} accepted; {self.silent:,} "
            f"recordings with nothing in them, {self.failed:,} that could not be read",
        ]
