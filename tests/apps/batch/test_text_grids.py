"""TextGrids, read back by praatio."""

from __future__ import annotations

import tempfile
from itertools import pairwise
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st
from praatio import textgrid
from praatio.data_classes.textgrid import Textgrid

from voz.apps.batch.outcomes import ErrorRow, Outcome, Row, SilentRow, UtteranceRow
from voz.apps.batch.scheduler import Finished
from voz.apps.batch.text_grids import text_grid, with_text_grids
from voz.events import SpokenWord

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
