"""Outputs: what is written is read back, the same each time, also as tables of pandas."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import pandas as pd
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
from voz.events import Alternative, SpokenWord
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


TABLE_HEADER = Header(
    "0.1.0", "print", "commands", "models", Recognition(), columns=("speaker", "age")
)
ANNE = {"speaker": "anne", "age": "07"}
ROWS: list[Row] = [
    SilentRow("a.wav", 1.5, ANNE),
    UtteranceRow("b.wav", 0.5, 1.25, "go #2, far", 0.875, True, slots={"far": 2}, manifest=ANNE),
    UtteranceRow("b.wav", 2.0, 3.0, "", 0.0, False, "unsure_between", ("go", "no"), manifest=ANNE),
    ErrorRow("c.wav", "c.wav: there is no such file"),
]


@pytest.fixture(params=TABLE_FORMATS)
def output(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    path = tmp_path / f"heard{request.param}"
    write_output(path, TABLE_HEADER, ROWS)
    return path


def test_results_are_the_same_table_whatever_their_format(output: Path) -> None:
    table = voz.read_results(output)
    assert list(table["file"]) == ["a.wav", "b.wav", "b.wav", "c.wav"]
    assert list(table.columns[-2:]) == ["speaker", "age"]
    assert table["seconds"].sum() == 1.5
    assert list(table["accepted"].fillna(False)) == [False, True, False, False]
    assert table["slots"][1] == {"far": 2}
    assert tuple(table["between"][2]) == ("go", "no")
    assert (table["text"][1], table["text"][2], table["age"][1]) == ("go #2, far", "", "07")
    assert table["error"].count() == 1
    assert table.attrs["header"]["fingerprint"] == "print"


def test_pandas_alone_finds_the_same_columns_and_rows(output: Path) -> None:
    read = {".jsonl": lambda path: pd.read_json(path, lines=True), ".csv": pd.read_csv}
    table = read.get(output.suffix, pd.read_parquet)(output)
    assert list(table.columns) == [*voz.read_results(output).columns, "header"]
    assert list(table["confidence"].dropna()) == [0.875, 0.0]
    assert table["header"].count() == 1
    assert len(table) == len(ROWS)


def test_without_pandas_it_is_said_how_to_install_it(
    output: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setattr("importlib.util._find_spec", lambda *_: None)
    with pytest.raises(voz.ConfigError, match=r"pandas is not installed; run .*\[pandas\]"):
        voz.read_results(output)
