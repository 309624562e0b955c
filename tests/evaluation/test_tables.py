from __future__ import annotations

from typing import Any

from voz.evaluation.comparison import Difference
from voz.evaluation.scores import score
from voz.evaluation.statistics import Estimate
from voz.evaluation.tables import Table, as_text, main_tables, shown, speaker_tables


def test_a_table_is_aligned() -> None:
    table = Table(("name", "clips"), [("a longer one", "5"), ("b", "1000")])
    assert as_text(table).splitlines() == [
        "name          clips",
        "a longer one      5",
        "b              1000",
    ]


def test_a_figure_is_shown_with_its_interval() -> None:
    assert shown(Estimate(0.9434, 0.921, 0.9619)) == "0.943 (0.92-0.96)"
    assert shown(Estimate(12.34, 0, 40.6), digits=1) == "12.3 (0-41)"


def test_only_what_was_scored_is_shown(result: Any) -> None:
    scores = score([result("stop", "stop"), result("go back", "go back", condition="far")])
    (table,) = main_tables(scores, [])
    assert [row[0] for row in table.rows] == ["mine", "  all", "  far"]
    assert speaker_tables(scores) == []


def test_kinds_that_share_a_table_are_told_apart(result: Any) -> None:
    scores = score([result("", kind="noise"), result("hello", kind="talk")])
    (table,) = main_tables(scores, [])
    assert [row[0] for row in table.rows] == ["mine, noise", "mine, talk"]


def test_the_worst_speakers_come_first(result: Any) -> None:
    scores = score([result("stop", "stop", speaker="ann"), result("stop", speaker="bob")])
    (table,) = speaker_tables(scores)
    assert [row[0].strip() for row in table.rows] == ["bob", "ann"]


def test_a_comparison_shows_the_difference() -> None:
    differences = [Difference("mine", None, 10, 0.9, 0.4, 5, 0, 0.0625)]
    (table,) = main_tables(score([]), differences)
    assert table.rows == [("mine", "10", "0.900", "0.400", "+0.500", "5", "0", "0.062")]
