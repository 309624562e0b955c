"""Outputs: JSON lines, CSV or Parquet, each with a header that says what it was made by."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from itertools import groupby, islice
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import msgspec

from voz.apps.batch.fingerprint import Header
from voz.apps.batch.places import Place, here, shown_place
from voz.apps.batch.rows import Decoded, Nothing, Row, Unreadable, as_row
from voz.errors import ConfigError
from voz.events import to_json
from voz.extras import how_to_install
from voz.files import atomic_write, os_errors_as_config_error

if TYPE_CHECKING:
    import pyarrow

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
"""Of tables: one for each field of all kinds of rows."""

NUMBERS = ("start", "end", "confidence", "score", "seconds")
NESTED = ("between", "slots")
"""Written as JSON in tables."""

BEFORE_HEADER = "# "
"""Of the first line of a CSV: `pandas.read_csv(..., skiprows=1)` leaves it out."""

AT_ONCE = 20_000
"""Rows of Parquet that are written together; that many are held in memory."""

Rows: TypeAlias = Iterable[Row]
Read: TypeAlias = AbstractContextManager[tuple[Header, Iterator[Row]]]


class Format(NamedTuple):
    """How an output is written and read.

    Attributes:
        write: takes the path, the header and the rows.
        read: opens a path, and gives the header and the rows.
    """

    write: Callable[[Path, Header, Rows], None]
    read: Callable[[Path], Read]


def format_of(output: Place) -> Format:
    """Find how an output is written by the ending of its name.

    Raises:
        ConfigError: no output has such an ending, or what writes it is not installed.
    """
    ending = PurePath(output).suffix
    if ending == ".parquet":
        _pyarrow()
    if ending not in FORMATS:
        raise ConfigError(f"{shown_place(output)}: end it with {', '.join(FORMATS)}")
    return FORMATS[ending]


def by_file(rows: Iterable[Row]) -> Iterator[tuple[str, tuple[Row, ...]]]:
    """Take the rows of each recording together."""
    for file, together in groupby(rows, key=lambda row: row.file):
        yield file, tuple(together)


def _write_json(path: Path, header: Header, rows: Rows) -> None:
    with os_errors_as_config_error(path), atomic_write(path) as file:
        file.write(to_json(header) + "\n")
        file.writelines(to_json(row) + "\n" for row in rows)


@contextmanager
def _read_json(path: Path) -> Iterator[tuple[Header, Iterator[Row]]]:
    with path.open(encoding="utf-8") as file:
        yield _header(file.readline()), (as_row(json.loads(line)) for line in file)


def _write_csv(path: Path, header: Header, rows: Rows) -> None:
    with os_errors_as_config_error(path), atomic_write(path) as file:
        file.write(f"{BEFORE_HEADER}{to_json(header)}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows([_cell(flat.get(name)) for name in COLUMNS] for flat in map(_flat, rows))


@contextmanager
def _read_csv(path: Path) -> Iterator[tuple[Header, Iterator[Row]]]:
    with path.open(encoding="utf-8", newline="") as file:
        header = _header(file.readline().removeprefix(BEFORE_HEADER))
        yield header, (_from_cells(cells) for cells in csv.DictReader(file))


def _write_parquet(path: Path, header: Header, rows: Rows) -> None:
    pa = _pyarrow()
    import pyarrow.parquet as pq

    kinds = {"accepted": pa.bool_(), **dict.fromkeys(NUMBERS, pa.float64())}
    schema = pa.schema(
        [(name, kinds.get(name, pa.string())) for name in COLUMNS],
        metadata={"voz": to_json(header)},
    )
    flats = map(_flat, rows)
    with (
        os_errors_as_config_error(path),
        atomic_write(path, "wb") as file,
        pq.ParquetWriter(file, schema, compression="zstd") as writer,
    ):
        while some := list(islice(flats, AT_ONCE)):
            writer.write_table(pa.Table.from_pylist(some, schema=schema))


@contextmanager
def _read_parquet(path: Path) -> Iterator[tuple[Header, Iterator[Row]]]:
    _pyarrow()
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        header = _header((file.schema_arrow.metadata or {}).get(b"voz", b"").decode())
        batches = file.iter_batches(AT_ONCE)
        yield header, (_from_flat(flat) for batch in batches for flat in batch.to_pylist())


FORMATS = {
    ".jsonl": Format(_write_json, _read_json),
    ".csv": Format(_write_csv, _read_csv),
    ".parquet": Format(_write_parquet, _read_parquet),
}


@contextmanager
def reading(output: Place) -> Iterator[tuple[Header, Iterator[Row]]]:
    """Read an output for the length of a `with` block.

    Yields:
        The header and the rows.

    Raises:
        ConfigError: it is none, or cannot be read.
    """
    try:
        with here(output) as path, format_of(output).read(path) as read:
            yield read
    except ConfigError:  # which is a ValueError too
        raise
    except OSError as error:
        reason = error.strerror or error
        raise ConfigError(f"{shown_place(output)}: cannot be read ({reason})") from error
    except (ValueError, KeyError, TypeError, msgspec.MsgspecError) as error:
        raise ConfigError(
            f"{shown_place(output)}: is no output of `voz decode --out` ({error}); name another"
        ) from error


def _header(line: str) -> Header:
    return msgspec.json.decode(line, type=Header)


def _flat(row: Row) -> dict[str, Any]:
    """A row as a table has it; what it holds besides texts and numbers is JSON."""
    flat = json.loads(to_json(row))
    return {
        name: json.dumps(value) if name in NESTED else float(value) if name in NUMBERS else value
        for name, value in flat.items()
    }


def _from_flat(flat: dict[str, Any]) -> Row:
    known = {name: value for name, value in flat.items() if value is not None}
    return as_row({n: json.loads(v) if n in NESTED else v for n, v in known.items()})


def _cell(value: Any) -> Any:
    return str(value).lower() if isinstance(value, bool) else value


def _from_cells(cells: dict[str, str]) -> Row:
    file = cells["file"]
    if cells["error"]:
        return Unreadable(file, cells["error"])
    if not cells["start"]:
        return Nothing(file, float(cells["seconds"]))
    flat: dict[str, Any] = {name: value for name, value in cells.items() if value}
    flat |= {name: float(flat[name]) for name in NUMBERS if name in flat}
    flat |= {"accepted": flat["accepted"] == "true", "text": cells["text"]}
    row = _from_flat(flat)
    assert isinstance(row, Decoded)
    return row


def _pyarrow() -> pyarrow:
    try:
        import pyarrow
    except ImportError as error:
        advice = how_to_install("parquet")
        raise ConfigError(f"pyarrow is not installed, which writes Parquet; {advice}") from error
    return pyarrow
