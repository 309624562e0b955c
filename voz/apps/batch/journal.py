"""The outcomes so far, in a database of SQLite beside the output.

Each outcome is a transaction of its own. The output is made of the journal at the end, in the order
of the input.
"""

from __future__ import annotations

import os
import sqlite3
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TypeAlias

import msgspec

from voz.apps.batch.fingerprint import Header, difference
from voz.apps.batch.locations import journal_path, shown_name
from voz.apps.batch.outcomes import Outcome, parse_row
from voz.apps.batch.stamps import RecordingStamp, Stamp
from voz.errors import ConfigError
from voz.events import to_json
from voz.files import os_errors_as_config_error, shown_path

SYNC_INTERVAL = 5.0
"""How often the journal is synced to the disk, s: a power failure loses so much, a kill nothing."""

SETUP = """
PRAGMA locking_mode = EXCLUSIVE;  -- until it is closed; NFS cannot share memory for other ways
PRAGMA journal_mode = WAL;
PRAGMA synchronous = NORMAL;
CREATE TABLE IF NOT EXISTS run (header TEXT);
CREATE TABLE IF NOT EXISTS recording
    (file TEXT PRIMARY KEY, rows TEXT, seconds REAL, cpu REAL, failed INTEGER, stamp TEXT)
    WITHOUT ROWID;
CREATE TEMP TABLE input (number INTEGER PRIMARY KEY, file TEXT);
"""

NamedOutcomes: TypeAlias = Iterable[tuple[str, Outcome]]
"""Recordings, as results name them, and their outcomes."""


class Journal:
    """Outcomes by recording; made by `open_journal`."""

    def __init__(self, database: sqlite3.Connection, path: Path, names: Sequence[str]) -> None:
        """Take a database, at a path, of recordings as results name them."""
        self._database, self._path = database, path
        self._synced = time.monotonic()
        with database:
            database.executemany("INSERT INTO input VALUES (?, ?)", enumerate(names))

    def missing(self, failed: bool = False) -> list[int]:
        """The indexes of recordings without an outcome, and of failed ones if asked."""
        found = self._database.execute(
            "SELECT number FROM input LEFT JOIN recording USING (file)"
            " WHERE rows IS NULL OR (? AND failed) ORDER BY number",
            (failed,),
        )
        return [number for (number,) in found]

    def add(self, file: str, outcome: Outcome) -> None:
        """Keep an outcome; raises sqlite3.Error if it cannot be written."""
        with self._database:
            _insert(self._database, [(file, outcome)])
        if time.monotonic() > self._synced + SYNC_INTERVAL:
            self._database.execute("PRAGMA wal_checkpoint")
            self._synced = time.monotonic()

    def outcomes(self) -> Iterator[Outcome]:
        """All outcomes in the order of the recordings; each must have one."""
        found = self._database.execute(
            "SELECT rows, seconds, cpu, stamp FROM input LEFT JOIN recording USING (file)"
            " ORDER BY number"
        )
        for rows, seconds, cpu, stamp in found:
            parsed = tuple(map(parse_row, msgspec.json.decode(rows)))
            yield Outcome(parsed, seconds, cpu, _stamp(stamp))

    def stamps(self) -> Iterator[tuple[int, RecordingStamp]]:
        """Index and stamp of each recording that has an outcome, in their order."""
        found = self._database.execute(
            "SELECT number, file, stamp FROM input JOIN recording USING (file) ORDER BY number"
        )
        for number, file, stamp in found:
            yield number, RecordingStamp(file, _stamp(stamp))

    def set_stamps(self, stamps: Iterable[tuple[int, Stamp]]) -> None:
        """Give recordings with the same bytes new stamps, by their indexes."""
        with self._database:
            self._database.executemany(
                "UPDATE recording SET stamp = ?"
                " WHERE file = (SELECT file FROM input WHERE number = ?)",
                ((to_json(stamp), number) for number, stamp in stamps),
            )

    def remove(self) -> None:
        """Remove the journal, whose output is written, before another run can lock it."""
        # Else closing it would remove a file beside it, which may be of the next run by then.
        self._database.execute("PRAGMA journal_mode = MEMORY")
        self._path.unlink()


@contextmanager
def open_journal(
    output: str,
    header: Header,
    names: Sequence[str],
    *,
    resume: bool,
    finished: NamedOutcomes = (),
    overwrite: bool = False,
) -> Iterator[Journal]:
    """Open the journal of an output and lock it, for the length of a `with` block.

    Args:
        output: for which it is.
        header: of this run.
        names: the recordings of this run, as results name them.
        resume: whether to go on from what is there, or else from what is `finished`.
        finished: the outcomes in the output that a run goes on from.
        overwrite: whether to begin again, whatever is there.

    Raises:
        ConfigError: another run has it, it is there and should not be, or has another header.
    """
    path = journal_path(output)
    with os_errors_as_config_error(path), _database(path, output) as database:
        there = _header_there(database, path)
        if there and resume:
            check_same_run(there, header, output)
        elif there and not overwrite:
            raise ConfigError(
                f"{shown_path(path)}: has an unfinished run; continue it with --resume, "
                "or start again with --overwrite"
            )
        else:
            with database:
                database.execute("DELETE FROM run")
                database.execute("DELETE FROM recording")
                database.execute("INSERT INTO run VALUES (?)", (to_json(header),))
                _insert(database, finished)
        yield Journal(database, path, names)


def check_same_run(there: Header, header: Header, output: str) -> None:
    """Raise ConfigError if an output or a journal was begun with another header."""
    if differing := difference(there, header, "shard", "drive"):
        raise ConfigError(
            f"{shown_name(output)}: was started with {differing}; use the same, or name "
            "another file by --out"
        )


@contextmanager
def _database(path: Path, output: str) -> Iterator[sqlite3.Connection]:
    """Open a journal, or make it, and lock it."""
    path.touch()
    seen = path.stat()
    try:
        with closing(sqlite3.connect(path, timeout=0)) as database:
            database.executescript(SETUP)
            if not path.exists() or not os.path.samestat(path.stat(), seen):
                raise ConfigError(f"{shown_name(output)}: was just written by another run")
            yield database
    except sqlite3.OperationalError as error:
        if "locked" not in str(error):
            raise ConfigError(f"{shown_path(path)}: cannot be written ({error})") from error
        raise ConfigError(
            f"{shown_name(output)}: is being written by another run; wait for it, or name "
            "another file by --out"
        ) from None
    except sqlite3.DatabaseError as error:
        raise _no_journal(path) from error


def _header_there(database: sqlite3.Connection, path: Path) -> Header | None:
    """Read the header; None if there is none, as in a new journal."""
    found = database.execute("SELECT header FROM run").fetchone()
    try:
        return found and msgspec.json.decode(found[0], type=Header)
    except msgspec.MsgspecError as error:
        raise _no_journal(path) from error


def _no_journal(path: Path) -> ConfigError:
    return ConfigError(f"{shown_path(path)}: is not a journal of voz; remove it")


def _insert(database: sqlite3.Connection, decoded: NamedOutcomes) -> None:
    records = (
        (file, f"[{','.join(map(to_json, o.rows))}]", o.seconds, o.cpu, o.failed,
         o.stamp and to_json(o.stamp))
        for file, o in decoded
    )  # fmt: skip
    database.executemany("INSERT OR REPLACE INTO recording VALUES (?, ?, ?, ?, ?, ?)", records)


def _stamp(found: str | None) -> Stamp | None:
    return msgspec.json.decode(found, type=Stamp) if found else None
