"""Outputs: what is written is read back, and the same each time."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.apps.batch.fingerprint import Header
from voz.apps.batch.formats import OUTPUT_FORMATS, format_of, group_by_file, open_output
from voz.apps.batch.outcomes import ErrorRow, Row, SilentRow, UtteranceRow
from voz.errors import ConfigError
from voz.settings import Recognition

HEADER = Header("0.1.0", "print", "commands", "models", Recognition(threshold=0.5))

texts = st.text(st.characters(exclude_categories=["Cs", "Cc"]), min_size=1, max_size=9)
seconds = st.floats(0, 1e5).map(lambda value: round(value, 3))
scores = st.floats(-99, 99).map(lambda value: round(value, 2))
slots = st.dictionaries(texts, texts | st.integers(-99, 99) | st.floats(0, 9), max_size=2)
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
)
rows = st.lists(
    heard | st.builds(SilentRow, texts, seconds) | st.builds(ErrorRow, texts, texts), max_size=20
)


@pytest.mark.parametrize("ending", OUTPUT_FORMATS)
@given(written=rows)
def test_what_is_written_is_read_back(ending: str, written: list[Row]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        one, other = Path(folder) / f"one{ending}", Path(folder) / f"other{ending}"
        format_of(str(one)).write(one, HEADER, written)
        with open_output(str(one)) as (header, read):
            back = list(read)
        format_of(str(other)).write(other, header, back)
        assert (header, back) == (HEADER, written)
        assert one.read_bytes() == other.read_bytes()


def test_parquet_has_the_header_and_types(tmp_path: Path) -> None:
    path = tmp_path / "heard.parquet"
    said = UtteranceRow("a.wav", 1.0, 2.0, "stop", 0.5, True, command="halt", slots={"n": 2})
    format_of(str(path)).write(path, HEADER, [said, SilentRow("b.wav", 3.0)])
    table = pq.read_table(path)
    assert table.column("start").to_pylist() == [1.0, None]
    assert table.column("command").to_pylist() == ["halt", None]
    assert b'"fingerprint":"print"' in table.schema.metadata[b"voz"]


@pytest.mark.parametrize("ending", OUTPUT_FORMATS)
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
