"""Output formats: JSON lines, CSV and Parquet, each with a header."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from itertools import groupby, islice
from pathlib import Path, PurePath
from typing import Any, TypeAlias

import msgspec

from voz.apps.batch.fingerprint import Header
from voz.apps.batch.locations import local_copy
from voz.apps.batch.outcomes import Row, parse_row
from voz.apps.batch.remote import shown_name
from voz.errors import ConfigError
from voz.events import to_json
from voz.extras import require
from voz.files import atomic_write, os_errors_as_config_error

TABLE_COLUMNS = (
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
"""One for each field of all types of rows."""

NUMBER_COLUMNS = ("start", "end", "confidence", "score", "seconds")
JSON_COLUMNS = ("between", "slots")
"""Columns whose cells are JSON."""

CSV_HEADER_PREFIX = "# "

PARQUET_BATCH_ROWS = 20_000
"""Rows that are written together, and held in memory."""

Rows: TypeAlias = Iterable[Row]
OpenedOutput: TypeAlias = AbstractContextManager[tuple[Header, Iterator[Row]]]


@dataclass(frozen=True)
class OutputFormat:
    """How an output is written and read."""

    write: Callable[[Path, Header, Rows], None]
    read: Callable[[Path], OpenedOutput]


def format_of(output: str) -> OutputFormat:
    """Return the format of an output, by the ending of its name.

    Raises:
        ConfigError: there is no such format, or its library is not installed.
    """
    ending = PurePath(output).suffix
    if ending == ".parquet":
        require("parquet", "pyarrow")
    if ending not in OUTPUT_FORMATS:
        raise ConfigError(f"{shown_name(output)}: end it with {', '.join(OUTPUT_FORMATS)}")
    return OUTPUT_FORMATS[ending]


def group_by_file(rows: Iterable[Row]) -> Iterator[tuple[str, tuple[Row, ...]]]:
    """Group successive rows of the same recording."""
    for file, together in groupby(rows, key=lambda row: row.file):
        yield file, tuple(together)


def _write_json(path: Path, header: Header, rows: Rows) -> None:
    with os_errors_as_config_error(path), atomic_write(path) as file:
        file.write(to_json(header) + "\n")
        file.writelines(to_json(row) + "\n" for row in rows)


@contextmanager
def _read_json(path: Path) -> Iterator[tuple[Header, Iterator[Row]]]:
    with path.open(encoding="utf-8") as file:
        yield _header(file.readline()), (parse_row(json.loads(line)) for line in file)


def _write_csv(path: Path, header: Header, rows: Rows) -> None:
    with os_errors_as_config_error(path), atomic_write(path) as file:
        file.write(f"{CSV_HEADER_PREFIX}{to_json(header)}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(TABLE_COLUMNS)
        writer.writerows(
            [_cell(flat.get(name)) for name in TABLE_COLUMNS] for flat in map(_flat, rows)
        )


@contextmanager
def _read_csv(path: Path) -> Iterator[tuple[Header, Iterator[Row]]]:
    with path.open(encoding="utf-8", newline="") as file:
        header = _header(file.readline().removeprefix(CSV_HEADER_PREFIX))
        yield header, (_from_cells(cells) for cells in csv.DictReader(file))


def _write_parquet(path: Path, header: Header, rows: Rows) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    kinds = {"accepted": pa.bool_(), **dict.fromkeys(NUMBER_COLUMNS, pa.float64())}
    schema = pa.schema(
        [(name, kinds.get(name, pa.string())) for name in TABLE_COLUMNS],
        metadata={"voz": to_json(header)},
    )
    flats = map(_flat, rows)
    with (
        os_errors_as_config_error(path),
        atomic_write(path, "wb") as file,
        pq.ParquetWriter(file, schema, compression="zstd") as writer,
    ):
        while some := list(islice(flats, PARQUET_BATCH_ROWS)):
            writer.write_table(pa.Table.from_pylist(some, schema=schema))


@contextmanager
def _read_parquet(path: Path) -> Iterator[tuple[Header, Iterator[Row]]]:
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        header = _header((file.schema_arrow.metadata or {}).get(b"voz", b"").decode())
        batches = file.iter_batches(PARQUET_BATCH_ROWS)
        yield header, (_from_flat(flat) for batch in batches for flat in batch.to_pylist())


OUTPUT_FORMATS = {
    ".jsonl": OutputFormat(_write_json, _read_json),
    ".csv": OutputFormat(_write_csv, _read_csv),
    ".parquet": OutputFormat(_write_parquet, _read_parquet),
}


@contextmanager
def open_output(output: str) -> Iterator[tuple[Header, Iterator[Row]]]:
    """Read the header and the rows of an output, in a `with` block.

    Raises:
        ConfigError: it is not an output, or cannot be read.
    """
    try:
        with local_copy(output) as path, format_of(output).read(path) as read:
            yield read
    except ConfigError:  # which is a ValueError too
        raise
    except OSError as error:
        reason = error.strerror or error
        raise ConfigError(f"{shown_name(output)}: cannot be read ({reason})") from error
    except (ValueError, KeyError, TypeError, msgspec.MsgspecError) as error:
        raise ConfigError(
            f"{shown_name(output)}: is not an output of `voz decode --out` ({error}); name another"
        ) from error


def _header(line: str) -> Header:
    return msgspec.json.decode(line, type=Header)


def _flat(row: Row) -> dict[str, Any]:
    """A row as a table has it: `JSON_COLUMNS` as JSON."""
    flat = json.loads(to_json(row))
    return {
        name: json.dumps(value)
        if name in JSON_COLUMNS
        else float(value)
        if name in NUMBER_COLUMNS
        else value
        for name, value in flat.items()
    }


def _from_flat(flat: dict[str, Any]) -> Row:
    known = {name: value for name, value in flat.items() if value is not None}
    return parse_row({n: json.loads(v) if n in JSON_COLUMNS else v for n, v in known.items()})


def _cell(value: Any) -> Any:
    return str(value).lower() if isinstance(value, bool) else value


def _from_cells(cells: dict[str, str]) -> Row:
    flat: dict[str, Any] = {name: value for name, value in cells.items() if value}
    flat |= {name: float(flat[name]) for name in NUMBER_COLUMNS if name in flat}
    if "accepted" in flat:  # an utterance, whose text may be empty
        flat |= {"accepted": flat["accepted"] == "true", "text": cells["text"]}
    return _from_flat(flat)
