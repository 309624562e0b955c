"""The outcomes so far, on disk: a line for each recording, in the order in which they end.

A killed process may leave part of a line, which is cut off the next time. The output is made of the
journal at the end, in the order of the input.
"""

from __future__ import annotations

import errno
import fcntl
import os
import time
from array import array
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import msgspec
from msgspec.structs import replace

from voz.apps.batch.fingerprint import Header, difference
from voz.apps.batch.locations import journal_path
from voz.apps.batch.outcomes import ErrorRow, Outcome, parse_row, row_type
from voz.apps.batch.remote import shown_name
from voz.apps.batch.stamps import RecordingStamp, Stamp
from voz.errors import ConfigError
from voz.events import to_json
from voz.files import os_errors_as_config_error, shown_path

FSYNC_INTERVAL = 5.0
"""How often the journal is synced to the disk, s: a power failure loses so much, a kill nothing."""

NO_OFFSET = -1


class JournalEntry(msgspec.Struct, frozen=True, omit_defaults=True):
    """A line: the rows of a recording, its length, s, and its state when it was decoded."""

    file: str
    rows: tuple[dict[str, object], ...]
    seconds: float = 0.0
    cpu: float = 0.0
    stamp: Stamp | None = None


class Journal:
    """Outcomes by recording; made by `open_journal`."""

    def __init__(self, file: int, names: Sequence[str]) -> None:
        """Read a file, open for reading and writing, of recordings as results name them."""
        self._file = file
        self._numbers = {name: number for number, name in enumerate(names)}
        self._at = array("q", [NO_OFFSET]) * len(names)
        self._failed = bytearray(len(names))
        self._saved = time.monotonic()
        with _reader(file) as lines:
            self._end = len(lines.readline())
            while (entry := _entry(line := lines.readline())) is not None:
                self._note(entry)
                self._end += len(line)
        os.ftruncate(file, self._end)

    def missing(self, failed: bool = False) -> list[int]:
        """The indexes of recordings without an outcome, and of failed ones if asked."""
        return [
            n for n, at in enumerate(self._at) if at == NO_OFFSET or (failed and self._failed[n])
        ]

    def add(self, file: str, outcome: Outcome) -> None:
        """Append an outcome, all of it or nothing; raises OSError if it cannot be written."""
        rows = tuple(msgspec.to_builtins(row) for row in outcome.rows)
        self._append(JournalEntry(file, rows, outcome.seconds, outcome.cpu, outcome.stamp))

    def _append(self, entry: JournalEntry) -> None:
        length = _write(self._file, self._end, entry)
        self._note(entry)
        self._end += length
        if time.monotonic() > self._saved + FSYNC_INTERVAL:
            os.fsync(self._file)
            self._saved = time.monotonic()

    def outcomes(self) -> Iterator[Outcome]:
        """All outcomes in the order of the recordings; each must have one."""
        with _reader(self._file) as lines:
            for at in self._at:
                lines.seek(at)
                entry = _entry(lines.readline())
                assert entry is not None
                rows = tuple(parse_row(row) for row in entry.rows)
                yield Outcome(rows, entry.seconds, entry.cpu, entry.stamp)

    def stamps(self) -> Iterator[tuple[int, RecordingStamp]]:
        """Index and stamp of each recording that has an outcome, in their order."""
        with _reader(self._file) as lines:
            for number, at in enumerate(self._at):
                if at != NO_OFFSET:
                    lines.seek(at)
                    yield number, msgspec.json.decode(lines.readline(), type=RecordingStamp)

    def set_stamp(self, number: int, stamp: Stamp) -> None:
        """Give a recording with the same bytes a new stamp."""
        with _reader(self._file) as lines:
            lines.seek(self._at[number])
            entry = _entry(lines.readline())
        assert entry is not None
        self._append(replace(entry, stamp=stamp))

    def _note(self, entry: JournalEntry) -> None:
        """Remember the offset of a line that begins at the end."""
        number = self._numbers.get(entry.file)
        if number is not None:  # else it is not in this input
            self._at[number] = self._end
            self._failed[number] = bool(entry.rows) and row_type(entry.rows[-1]) is ErrorRow


@contextmanager
def open_journal(
    output: str,
    header: Header,
    names: Sequence[str],
    *,
    resume: bool,
    finished: Iterable[JournalEntry] = (),
    overwrite: bool = False,
) -> Iterator[Journal]:
    """Open the journal of an output and lock it, for the length of a `with` block.

    Args:
        output: for which it is.
        header: of this run.
        names: the recordings of this run, as results name them.
        resume: whether to go on from what is there, or else from the `finished` entries.
        finished: those of the output that a run goes on from.
        overwrite: whether to begin again, whatever is there.

    Raises:
        ConfigError: another run has it, it is there and should not be, or has another header.
    """
    path = journal_path(output)
    with os_errors_as_config_error(path), _locked(path, output) as file:
        there = _header_there(file, path)
        if there and resume:
            check_same_run(there, header, output)
        elif there and not overwrite:
            raise ConfigError(
                f"{shown_path(path)}: has an unfinished run; continue it with --resume, "
                "or start again with --overwrite"
            )
        else:
            os.ftruncate(file, 0)
            end = _write(file, 0, header)
            for entry in finished:
                end += _write(file, end, entry)
        yield Journal(file, names)


def _header_there(file: int, path: Path) -> Header | None:
    """Read the header; None if there is none, as in a new journal."""
    with _reader(file) as lines:
        line = lines.readline()
    if not line.endswith(b"\n"):
        return None
    try:
        return msgspec.json.decode(line, type=Header)
    except msgspec.MsgspecError as error:
        raise ConfigError(f"{shown_path(path)}: is not a journal of voz; remove it") from error


def check_same_run(there: Header, header: Header, output: str) -> None:
    """Raise ConfigError if an output or a journal was begun with another header."""
    differing = difference(there, header)
    if not differing and there.shard != header.shard:
        differing = f"shard {there.shard or 'none'}"
    if not differing and there.drive != header.drive:
        differing = "other rules to drive by" if there.drive else "no --drive"
    if differing:
        raise ConfigError(
            f"{shown_name(output)}: was started with {differing}; use the same, or name "
            "another file by --out"
        )


@contextmanager
def _locked(path: Path, output: str) -> Iterator[int]:
    file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    try:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ConfigError(
                f"{shown_name(output)}: is being written by another run; wait for it, or name "
                "another file by --out"
            ) from None
        if not _is_still(path, file):
            raise ConfigError(f"{shown_name(output)}: was just written by another run")
        yield file
    finally:
        os.close(file)


def _is_still(path: Path, file: int) -> bool:
    """Whether a path leads to an open file: another run may have removed it meanwhile."""
    try:
        return os.path.samestat(path.stat(), os.fstat(file))
    except OSError:
        return False


@contextmanager
def _reader(file: int) -> Iterator[BinaryIO]:
    """Read from the beginning, without an old buffer."""
    with open(file, "rb", closefd=False) as lines:
        lines.seek(0)
        yield lines


def _write(file: int, at: int, record: msgspec.Struct) -> int:
    """Write a line, all of it or nothing; returns its length in bytes."""
    data = to_json(record).encode("utf-8", "backslashreplace") + b"\n"
    try:
        if os.pwrite(file, data, at) < len(data):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    except OSError:
        os.ftruncate(file, at)
        raise
    return len(data)


def _entry(line: bytes) -> JournalEntry | None:
    """Decode a line; None if it is incomplete."""
    if not line.endswith(b"\n"):
        return None
    try:
        return msgspec.json.decode(line, type=JournalEntry)
    except msgspec.MsgspecError:
        return None
