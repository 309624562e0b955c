"""CTM, read as its description says: six fields parted by white space, and comments by `;;`."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.apps.batch.fingerprint import Header
from voz.apps.batch.formats import open_output, write_output
from voz.apps.batch.outcomes import ErrorRow, Row, SilentRow, UtteranceRow
from voz.errors import ConfigError
from voz.events import SpokenWord
from voz.settings import Recognition

HEADER = Header("0.1.0", "print", "commands", "models", Recognition(), words=True)

times = st.floats(0, 1e4).map(lambda value: round(value, 3))
said = st.text(st.characters(categories=["L", "N"]) | st.sampled_from("'\"-;%"), min_size=1)
files = st.text(st.characters(exclude_categories=["Cs"]) | st.sampled_from(' "\t;%é\n'), min_size=1)
words = st.lists(st.builds(SpokenWord, said, times, times), max_size=3).map(tuple)
heard = st.builds(
    lambda file, sure, accepted, spoken: UtteranceRow(
        file, 0.0, 1.0, " ".join(w.word for w in spoken), sure, accepted, words=spoken
    ),
    files,
    st.floats(0, 1),
    st.booleans(),
    words,
)
rows = st.lists(heard | st.builds(SilentRow, files, times) | st.builds(ErrorRow, files, files))


def lines_of(written: list[Row]) -> list[str]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "heard.ctm")
        write_output(path, HEADER, written)
        return path.read_bytes().decode().split("\n")[:-1]


@given(rows)
def test_each_accepted_word_is_a_line_of_six_fields(written: list[Row]) -> None:
    told = [line for line in lines_of(written) if not line.startswith(";;")]
    accepted = [row for row in written if isinstance(row, UtteranceRow) and row.accepted]
    expected = [(row, word) for row in accepted for word in row.words]
    names: dict[str, str] = {}
    for line, (row, word) in zip(told, expected, strict=True):
        name, channel, start, duration, text, sure = line.split()
        assert names.setdefault(name, row.file) == row.file  # different ones stay so
        assert (channel, float(start), text) == ("1", word.start, word.word)
        assert float(duration) == pytest.approx(max(0, word.end - word.start), abs=1e-6)
        assert float(sure) == pytest.approx(row.confidence, abs=0.0006)


def test_what_was_refused_or_not_read_is_a_comment() -> None:
    go = (SpokenWord("go", 0.5, 0.75),)
    written: list[Row] = [
        UtteranceRow("my room/a.wav", 0.4, 1.0, "go", 0.25, False, "not_a_command", words=go),
        UtteranceRow("my room/a.wav", 2.0, 3.0, "go", 0.875, True, words=go),
        SilentRow("b.wav", 3.0),
        ErrorRow("c.wav", "c.wav: no\nsound"),
    ]
    first, *rest = lines_of(written)
    assert first.startswith(';; {"voz": "0.1.0"')
    assert rest == [
        ";; my%20room/a.wav 1 0.500 0.250 go 0.250",
        "my%20room/a.wav 1 0.500 0.250 go 0.875",
        ";; c.wav: no sound",
    ]


def test_it_is_not_read_back(tmp_path: Path) -> None:
    write_output(tmp_path / "heard.ctm", HEADER, [])
    with (
        pytest.raises(ConfigError, match="has words alone, and is not read back"),
        open_output(str(tmp_path / "heard.ctm")),
    ):
        pass
