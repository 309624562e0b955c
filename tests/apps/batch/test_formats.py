"""Outputs: what is written is read back, and the same each time."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

import voz
from voz.apps.batch.fingerprint import Header
from voz.apps.batch.formats import (
    OUTPUT_FORMATS,
    TABLE_FORMATS,
    group_by_file,
    open_output,
    write_output,
)
from voz.apps.batch.outcomes import COLUMNS, ErrorRow, Row, SilentRow, UtteranceRow
from voz.errors import ConfigError
from voz.events import Alternative, SpokenWord, to_json
from voz.settings import Recognition

HEADER = Header(
    "0.1.0",
    "print",
    "commands",
    "models",
    Recognition(threshold=0.5),
    columns=("speaker", "manifest_text"),
    words=True,
    best=2,
)

texts = st.text(st.characters(exclude_categories=["Cs", "Cc"]), min_size=1, max_size=9)
seconds = st.floats(0, 1e5).map(lambda value: round(value, 3))
scores = st.floats(-99, 99).map(lambda value: round(value, 2))
slots = st.dictionaries(texts, texts | st.integers(-99, 99) | st.floats(0, 9), max_size=2)
manifest = st.dictionaries(st.sampled_from(["speaker", "manifest_text"]), texts)
words = st.lists(st.builds(SpokenWord, texts, seconds, seconds), max_size=3).map(tuple)
best = st.lists(st.builds(Alternative, texts, st.floats(0, 1)), max_size=2).map(tuple)
heard = st.builds(
    UtteranceRow,
    texts,
    seconds,
    seconds,
    st.just("") | texts,
    st.floats(0, 1),
    st.booleans(),
    st.none() | st.sampled_from(["too_short", "unsure_between"]),
    st.none() | st.tuples(texts, texts),
    st.none() | scores,
    st.none() | texts,
    st.none(),
    slots,
    words,
    best,
    manifest,
)
rows = st.lists(
    heard
    | st.builds(SilentRow, texts, seconds, manifest)
    | st.builds(ErrorRow, texts, texts, manifest),
    max_size=20,
)


@pytest.mark.parametrize("ending", TABLE_FORMATS)
@given(written=rows)
def test_what_is_written_is_read_back(ending: str, written: list[Row]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        one, other = Path(folder) / f"one{ending}", Path(folder) / f"other{ending}"
        write_output(one, HEADER, written)
        with open_output(str(one)) as (header, read):
            back = list(read)
        write_output(other, header, back)
        assert (header, back) == (HEADER, written)
        assert one.read_bytes() == other.read_bytes()


@pytest.mark.parametrize("ending", OUTPUT_FORMATS)
def test_there_are_columns_of_details_only_if_asked_for(ending: str, tmp_path: Path) -> None:
    plain, detailed = tmp_path / f"plain{ending}", tmp_path / f"detailed{ending}"
    said = UtteranceRow("a.wav", 1.0, 2.0, "stop", 0.5, True)
    columns = [*COLUMNS, *HEADER.columns]
    if ending == ".ctm":
        with pytest.raises(ConfigError, match="needs the times of words; decode with --words"):
            write_output(plain, replace(HEADER, words=False), [said])
        return
    write_output(plain, replace(HEADER, words=False, best=0), [said])
    assert list(voz.read_results(plain).columns) == columns
    details = {"words": (SpokenWord("stop", 1.25, 1.75),), "best": (Alternative("stop", 0.5),)}
    write_output(detailed, HEADER, [replace(said, **details), SilentRow("b.wav", 1.0)])
    table = voz.read_results(detailed)
    assert list(table.columns) == [*COLUMNS, "words", "best", *HEADER.columns]
    assert table["words"][0] == [{"word": "stop", "start": 1.25, "end": 1.75}]
    assert table["best"][0] == [{"text": "stop", "confidence": 0.5}]
    assert table["words"].isna().tolist() == [False, True]


def test_parquet_has_the_header_and_types(tmp_path: Path) -> None:
    path = tmp_path / "heard.parquet"
    said = UtteranceRow("a.wav", 1.0, 2.0, "stop", 0.5, True, command="halt", slots={"n": 2})
    write_output(path, HEADER, [said, SilentRow("b.wav", 3.0)])
    table = pq.read_table(path)
    assert table.column("start").to_pylist() == [1.0, None]
    assert table.column("command").to_pylist() == ["halt", None]
    first, second = table.column("header").to_pylist()
    assert '"fingerprint": "print"' in first
    assert second is None


def test_what_version_0_1_wrote_is_still_read(tmp_path: Path) -> None:
    header = replace(HEADER, columns=(), words=False, best=0)
    line, heard = to_json(header), '"file":"a.wav","start":1.0,"end":2.0,"text":"","confidence":0.5'
    jsonl, table, parquet = (tmp_path / f"heard{ending}" for ending in TABLE_FORMATS)
    jsonl.write_text(f'{line}\n{{{heard},"accepted":false}}\n{{"file":"b.wav","seconds":3.0}}\n')
    cells = "file,start,end,text,confidence,accepted,reason,slots,seconds,error"
    table.write_text(f"# {line}\n{cells}\na.wav,1.0,2.0,,0.5,false,,,,\nb.wav,,,,,,,,3.0,\n")
    said = {"file": "a.wav", "start": 1.0, "end": 2.0, "text": "", "confidence": 0.5}
    rows = [said | {"accepted": False}, {"file": "b.wav", "seconds": 3.0}]
    written = pa.Table.from_pylist(rows, pa.schema(
        [("file", pa.string()), ("start", pa.float64()), ("end", pa.float64()),
         ("text", pa.string()), ("confidence", pa.float64()), ("accepted", pa.bool_()),
         ("seconds", pa.float64())], metadata={"voz": line}))  # fmt: skip
    pq.write_table(written, parquet)
    known = [UtteranceRow("a.wav", 1.0, 2.0, "", 0.5, False), SilentRow("b.wav", 3.0)]
    for output in (jsonl, table, parquet):
        with open_output(str(output)) as (read, back):
            assert (read, list(back)) == (header, known)


def test_an_output_without_rows_has_its_header(tmp_path: Path) -> None:
    for ending in TABLE_FORMATS:
        write_output(tmp_path / f"heard{ending}", HEADER, [])
        with open_output(str(tmp_path / f"heard{ending}")) as (header, read):
            assert (header, list(read)) == (HEADER, [])
        assert len(voz.read_results(tmp_path / f"heard{ending}")) == 0


@pytest.mark.parametrize("ending", TABLE_FORMATS)
def test_what_is_no_output_is_a_line(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"heard{ending}"
    path.write_text("something else\n")
    with (
        pytest.raises(ConfigError, match="is not an output of"),
        open_output(str(path)) as (_, read),
    ):
        list(read)
    path.unlink()
    with pytest.raises(ConfigError, match="cannot be read"), open_output(str(path)):
        pass


def test_rows_are_taken_together_by_recording() -> None:
    found = [SilentRow("a", 1.0), ErrorRow("b", "x"), ErrorRow("b", "y")]
    assert [(file, len(of_file)) for file, of_file in group_by_file(found)] == [("a", 1), ("b", 2)]
