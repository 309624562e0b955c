from __future__ import annotations

from typing import Any

from voz.apps.evaluation.scores import AlarmDifference, Difference, score
from voz.apps.evaluation.statistics import Estimate, alarm_rate
from voz.apps.evaluation.tables import (
    Table,
    alarm_rate_text,
    estimate_text,
    main_tables,
    speaker_tables,
    table_text,
)


def test_a_table_is_aligned() -> None:
    table = Table(("name", "clips"), [("a longer one", "5"), ("b", "1000")])
    assert table_text(table).splitlines() == [
        "name          clips",
        "a longer one      5",
        "b              1000",
    ]


def test_a_figure_is_shown_with_its_interval() -> None:
    assert estimate_text(Estimate(0.9434, 0.921, 0.9619)) == "0.943 (0.92-0.96)"
    assert estimate_text(Estimate(12.34, 0, 40.6), digits=1) == "12.3 (0-41)"


def test_alarms_are_shown_with_the_hours_they_come_from() -> None:
    assert alarm_rate_text(alarm_rate(0, hours=0.6)) == "0 in 0.6 h (0 to 6.1 per hour)"
    assert alarm_rate_text(alarm_rate(40, hours=16.3 / 60)) == "40 in 0.27 h (105 to 200 per hour)"
    assert alarm_rate_text(alarm_rate(3, hours=123.4)) == "3 in 123 h (0.005 to 0.071 per hour)"


def test_alarms_are_shown_with_the_commands_that_were_obeyed(result: Any) -> None:
    heard = [["stop"], ["go back", "stop"], ["stop?"]]
    talk = [result("hi", *texts, kind="talk", seconds=1800.0, speaker="ann") for texts in heard]
    (table,) = main_tables(score(talk), [])
    assert table.rows[0][2] == "stop 2, go back 1"


def test_noises_are_told_apart_if_there_are_several(result: Any) -> None:
    tap, motor = (result("stop", "stop", snr=5.0, noise=name) for name in ("tap", "motor"))
    (one,) = main_tables(score([tap]), [])
    assert [row[0] for row in one.rows] == ["  5 dB"]
    (two,) = main_tables(score([tap, motor]), [])
    assert [row[0] for row in two.rows] == ["  5 dB", "  motor, 5 dB", "  tap, 5 dB"]


def test_what_is_obeyed_out_of_nothing_is_named_with_its_noise(result: Any) -> None:
    kind = {"kind": "out-of-nothing", "seconds": 360.0}
    rows = [result("", **kind), result("", "stop", snr=5.0, noise="tap", **kind)]
    (table,) = main_tables(score(rows), [])
    assert list(table.rows) == [
        ("mine, out-of-nothing", "0 in 0.1 h (0 to 37 per hour)", ""),
        ("mine, out-of-nothing, 5 dB", "1 in 0.1 h (0.25 to 56 per hour)", "stop 1"),
    ]


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
    alarms = [AlarmDifference("mine", "talk", None, alarm_rate(0, 1), alarm_rate(2, 1))]
    (table, other) = main_tables(score([]), differences, alarms=alarms)
    assert table.rows == [("mine", "10", "0.900", "0.400", "+0.500", "5", "0", "0.062")]
    assert other.rows == [
        ("mine, talk", "0 in 1 h (0 to 3.7 per hour)", "2 in 1 h (0.24 to 7.2 per hour)")
    ]
