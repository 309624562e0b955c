"""CTM as its description says, and TextGrids that praatio reads back."""

from __future__ import annotations

import tempfile
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from praatio import textgrid
from praatio.data_classes.textgrid import Textgrid

from voz.apps.batch.alignments import text_grid, with_text_grids
from voz.apps.batch.batch_decoder import Finished
from voz.apps.batch.fingerprint import Header
from voz.apps.batch.formats import open_output, write_output
from voz.apps.batch.outcomes import ErrorRow, Outcome, Row, SilentRow, UtteranceRow
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


letters = st.characters(exclude_categories=["C", "Z"]) | st.sampled_from("\"'<>[]:=é")
word = st.text(letters, min_size=1, max_size=8)


@st.composite
def outcomes(draw: st.DrawFn) -> Outcome:
    """Utterances one after the other, of one to three words."""
    now = draw(st.integers(0, 999))
    rows: list[Row] = []
    for _ in range(draw(st.integers(0, 4))):
        said = []
        for text in draw(st.lists(word, min_size=1, max_size=3)):
            begin = now + draw(st.integers(0, 500))
            now = begin + draw(st.integers(1, 500))
            said.append(SpokenWord(text, begin / 1000, now / 1000))
        texts = " ".join(each.word for each in said)
        rows.append(
            UtteranceRow(
                *("a.wav", said[0].start, said[-1].end, texts, 0.5, draw(st.booleans())),
                words=tuple(said),
            )
        )
    seconds = (now + draw(st.integers(1, 5000))) / 1000
    return Outcome(tuple(rows) or (SilentRow("a.wav", seconds),), seconds)


def read(outcome: Outcome) -> Textgrid:
    """Read a TextGrid; praatio raises if it has gaps, overlaps or another length."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.TextGrid")
        path.write_text(text_grid(outcome), encoding="utf-8")
        return textgrid.openTextgrid(str(path), includeEmptyIntervals=True, reportingMode="error")


def labels(grid: Textgrid, tier: str) -> list[tuple[float, float, str]]:
    return [tuple(each) for each in grid.getTier(tier).entries if each.label]


@given(outcomes())
def test_what_is_written_is_read_back(outcome: Outcome) -> None:
    grid = read(outcome)
    heard = [row for row in outcome.rows if isinstance(row, UtteranceRow)]
    assert labels(grid, "words") == [(w.start, w.end, w.word) for row in heard for w in row.words]
    for tier, accepted in (("accepted", True), ("refused", False)):
        said = [(h.start, h.end, h.text) for h in heard if h.accepted is accepted]
        assert labels(grid, tier) == said
    for tier in grid.tiers:
        assert tier.entries[0].start == 0
        assert tier.entries[-1].end == grid.maxTimestamp == outcome.seconds
        assert all(one.end == other.start for one, other in pairwise(tier.entries))


def test_a_refusal_without_a_text_has_its_reason_and_what_overlaps_is_cut() -> None:
    odd = UtteranceRow("a", 0.9, 2.5, "", 0.0, False, "unsure_between", ("go", "no"))
    first = UtteranceRow("a", 0.5, 1.5, "go", 0.1, False, words=(SpokenWord("go", 0.5, 1.5),))
    inside = UtteranceRow("a", 0.6, 1.0, "no", 0.1, False, words=(SpokenWord("no", 1.4, 2.5),))
    grid = read(Outcome((first, inside, odd), 2.0))
    assert labels(grid, "words") == [(0.5, 1.5, "go"), (1.5, 2.5, "no")]
    assert labels(grid, "refused") == [
        (0.5, 1.5, "go"),
        (1.5, 2.5, '(unsure between "go" and "no")'),
    ]
    assert grid.maxTimestamp == 2.5


def test_each_recording_that_was_heard_has_a_file_named_after_it(tmp_path: Path) -> None:
    heard = Outcome((SilentRow("rooms/kitchen 1.wav", 2.0),), 2.0)
    unreadable = Outcome((ErrorRow("b.wav", "b.wav: cannot be read"),))
    finished = [Finished(1, heard), Finished(0, unreadable)]
    assert list(with_text_grids(finished, tmp_path)) == finished
    (path,) = tmp_path.iterdir()
    assert path.name == "rooms+kitchen 1.wav.TextGrid"
    assert path.read_text() == text_grid(heard)
