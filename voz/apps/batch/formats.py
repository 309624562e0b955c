"""Output formats: JSON lines, CSV and Parquet, with the same columns; the first row has the header.

A CTM has the words alone, and cannot be read back.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from itertools import chain, groupby, islice
from os import PathLike
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, TypeAlias

import msgspec

from voz.apps.batch.alignments import COMMENT, TEXT_GRID_ENDING, ctm_lines
from voz.apps.batch.fingerprint import Header
from voz.apps.batch.locations import local_copy, shown_name
from voz.apps.batch.outcomes import (
    COLUMNS,
    DETAIL_COLUMNS,
    HEADER_COLUMN,
    Row,
    parse_row,
    row_fields,
)
from voz.errors import ConfigError
from voz.extras import require
from voz.files import atomic_write, os_errors_as_config_error, shown_path
from voz.records import check_path

if TYPE_CHECKING:
    import pandas as pd


NUMBER_COLUMNS = ("start", "end", "confidence", "score", "seconds")
JSON_COLUMNS = ("between", "slots", *DETAIL_COLUMNS, HEADER_COLUMN)
"""Columns whose cells in tables are JSON."""

CTM_ENDING = ".ctm"

PARQUET_BATCH_ROWS = 20_000
"""Rows that are written together, and held in memory."""

Rows: TypeAlias = Iterable[Row]
Record: TypeAlias = dict[str, Any]
"""The fields of a row by their columns; None where there is nothing."""


@dataclass(frozen=True)
class OutputFormat:
    """How records are written and read."""

    write: Callable[[Path, tuple[str, ...], Iterator[Record]], None]
    read: Callable[[Path], AbstractContextManager[Iterator[Record]]]
    of_words: bool = False  # whether it has words and their times alone


def format_of(output: str) -> OutputFormat:
    """Return the format of an output, by the ending of its name.

    Raises:
        ConfigError: there is no such format, or its library is not installed.
    """
    ending = PurePath(output).suffix
    if ending == ".parquet":
        require("parquet", "pyarrow")
    if ending == TEXT_GRID_ENDING:
        advice = "each recording has a TextGrid of its own; write them with --textgrids DIR"
        raise ConfigError(f"{shown_name(output)}: {advice}")
    if ending not in OUTPUT_FORMATS:
        raise ConfigError(f"{shown_name(output)}: end it with {', '.join(OUTPUT_FORMATS)}")
    return OUTPUT_FORMATS[ending]


def write_output(path: Path, header: Header, rows: Rows) -> None:
    """Write an output into a file; raises ConfigError if it cannot be written."""
    output_format = format_of(str(path))
    if output_format.of_words and not header.words:
        raise ConfigError(f"{shown_path(path)}: needs the times of words; decode with --words")
    columns = (*COLUMNS, *header.details, *header.columns, HEADER_COLUMN)
    with os_errors_as_config_error(path):
        output_format.write(path, columns, _records(columns, header, rows))


@contextmanager
def open_output(output: str) -> Iterator[tuple[Header, Iterator[Row]]]:
    """Read the header and the rows of an output, in a `with` block.

    Raises:
        ConfigError: it is not an output, or cannot be read.
    """
    with open_records(output) as (header, records):
        yield header, (_row(record, header) for record in records)


@contextmanager
def open_records(output: str) -> Iterator[tuple[Header, Iterator[Record]]]:
    """Read the header and the rows of an output as they are written, in a `with` block.

    Raises:
        ConfigError: it is not an output, or cannot be read.
    """
    try:
        with local_copy(output) as path, format_of(output).read(path) as records:
            first = next(records)
            header = msgspec.convert(first.pop(HEADER_COLUMN), Header)
            known = [first] if first.get("file") else []
            yield header, chain(known, records)
    except ConfigError:  # which is a ValueError too
        raise
    except OSError as error:
        reason = error.strerror or error
        raise ConfigError(f"{shown_name(output)}: cannot be read ({reason})") from error
    except (ValueError, LookupError, TypeError, StopIteration, msgspec.MsgspecError) as error:
        reason = str(error) or "it is empty"
        raise ConfigError(
            f"{shown_name(output)}: is not an output of `voz decode --out` ({reason}); name another"
        ) from error


def group_by_file(rows: Iterable[Row]) -> Iterator[tuple[str, tuple[Row, ...]]]:
    """Group successive rows of the same recording."""
    for file, together in groupby(rows, key=lambda row: row.file):
        yield file, tuple(together)


def _records(columns: tuple[str, ...], header: Header, rows: Rows) -> Iterator[Record]:
    """The rows with all columns; without any, one that has the header alone."""
    empty = dict.fromkeys(columns)
    first = {HEADER_COLUMN: msgspec.to_builtins(header)}
    for row in rows:
        yield empty | row_fields(row) | first
        first = {}
    if first:
        yield empty | first


def _row(record: Record, header: Header) -> Row:
    fields = {name: value for name, value in record.items() if value is not None}
    fields.pop(HEADER_COLUMN, None)
    manifest = {name: fields.pop(name) for name in header.columns if name in fields}
    return parse_row({**fields, "manifest": manifest} if manifest else fields)


def _write_json(path: Path, _: tuple[str, ...], records: Iterator[Record]) -> None:
    with atomic_write(path) as file:
        file.writelines(f"{msgspec.json.encode(record).decode()}\n" for record in records)


@contextmanager
def _read_json(path: Path) -> Iterator[Iterator[Record]]:
    with path.open(encoding="utf-8") as file:
        yield map(json.loads, file)


def _write_csv(path: Path, columns: tuple[str, ...], records: Iterator[Record]) -> None:
    with atomic_write(path) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(map(_cell, _flat(record).values()) for record in records)


@contextmanager
def _read_csv(path: Path) -> Iterator[Iterator[Record]]:
    with path.open(encoding="utf-8", newline="") as file:
        yield (_nested(_from_cells(cells)) for cells in csv.DictReader(file))


def _write_parquet(path: Path, columns: tuple[str, ...], records: Iterator[Record]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    kinds = {"accepted": pa.bool_(), **dict.fromkeys(NUMBER_COLUMNS, pa.float64())}
    schema = pa.schema([(name, kinds.get(name, pa.string())) for name in columns])
    flats = map(_flat, records)
    with (
        atomic_write(path, "wb") as file,
        pq.ParquetWriter(file, schema, compression="zstd") as writer,
    ):
        while some := list(islice(flats, PARQUET_BATCH_ROWS)):
            writer.write_table(pa.Table.from_pylist(some, schema=schema))


@contextmanager
def _read_parquet(path: Path) -> Iterator[Iterator[Record]]:
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        batches = file.iter_batches(PARQUET_BATCH_ROWS)
        yield (_nested(flat) for batch in batches for flat in batch.to_pylist())


def _write_ctm(path: Path, _: tuple[str, ...], records: Iterator[Record]) -> None:
    with atomic_write(path) as file:
        for record in records:
            if header := record[HEADER_COLUMN]:
                file.write(f"{COMMENT} {json.dumps(header, ensure_ascii=False)}\n")
            if record["file"] is not None:
                file.writelines(f"{line}\n" for line in ctm_lines(record))


@contextmanager
def _read_ctm(path: Path) -> Iterator[Iterator[Record]]:
    advice = "name a .jsonl, .csv or .parquet, or begin again with --overwrite"
    raise ConfigError(f"{shown_path(path)}: has words alone, and is not read back; {advice}")
    yield iter(())


TABLE_FORMATS = {
    ".jsonl": OutputFormat(_write_json, _read_json),
    ".csv": OutputFormat(_write_csv, _read_csv),
    ".parquet": OutputFormat(_write_parquet, _read_parquet),
}

OUTPUT_FORMATS = {**TABLE_FORMATS, CTM_ENDING: OutputFormat(_write_ctm, _read_ctm, of_words=True)}


def _flat(record: Record) -> Record:
    """A record as a table has it: `JSON_COLUMNS` as JSON."""
    return {
        name: json.dumps(value, ensure_ascii=False)
        if name in JSON_COLUMNS and value is not None
        else float(value)
        if name in NUMBER_COLUMNS and value is not None
        else value
        for name, value in record.items()
    }


def _nested(flat: Record) -> Record:
    """The opposite of `_flat`."""
    return {n: json.loads(v) if n in JSON_COLUMNS and v else v for n, v in flat.items()}


def _cell(value: Any) -> Any:
    return str(value).lower() if isinstance(value, bool) else value


def _from_cells(cells: Mapping[str, str]) -> Record:
    found: Record = {name: value or None for name, value in cells.items()}
    found |= {name: float(cells[name]) for name in NUMBER_COLUMNS if cells.get(name)}
    if cells.get("accepted"):  # an utterance, whose text may be empty
        found |= {"accepted": cells["accepted"] == "true", "text": cells["text"]}
    return found


def read_results(output: str | PathLike[str]) -> pd.DataFrame:
    """Read an output of `voz decode --out` into a DataFrame, the same one whatever its format.

    Args:
        output: a file that ends with .jsonl, .csv or .parquet, or an address of one.

    Returns:
        A row for each utterance, silent or unreadable recording; the columns of a manifest are
        beside the others. `attrs["header"]` is what the output was made by.

    Raises:
        ConfigError: it is not an output, or pandas is not installed.
    """
    require("pandas", "pandas")
    import pandas as pd

    name = check_path(output, "output")
    with open_records(name) as (header, records):
        columns = [*COLUMNS, *header.details, *header.columns]
        table = pd.DataFrame.from_records(list(records), columns=columns)
    table = table.astype({**dict.fromkeys(NUMBER_COLUMNS, "float64"), "accepted": "boolean"})
    table.attrs["header"] = msgspec.to_builtins(header)
    return table
