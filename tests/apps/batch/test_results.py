"""Outputs as tables of pandas: by voz, and by pandas alone."""

from __future__ import annotations

import sys
from pathlib import Path

import pandas as pd
import pytest

import voz
from voz.apps.batch.fingerprint import Header
from voz.apps.batch.formats import TABLE_FORMATS, write_output
from voz.apps.batch.outcomes import ErrorRow, Row, SilentRow, UtteranceRow
from voz.settings import Recognition

HEADER = Header("0.1.0", "print", "commands", "models", Recognition(), columns=("speaker", "age"))
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
    write_output(path, HEADER, ROWS)
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


def test_what_is_no_output_is_a_line(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text("a,b\n1,2\n")
    with pytest.raises(voz.ConfigError, match="is not an output of `voz decode --out`"):
        voz.read_results(tmp_path / "mine.csv")
