from __future__ import annotations

from typing import Any

from voz.apps.evaluation.comparison import AlarmDifference, Difference, compare, compare_alarms
from voz.apps.evaluation.statistics import alarm_rate


def test_clips_are_paired_by_name_and_noise(result: Any) -> None:
    here = [
        result("stop", "stop", file="a"),
        result("stop", "stop", file="b"),
        result("stop", "stop?", file="c"),
        result("stop", "stop", file="d", snr=5.0),
        result("stop", "stop", file="only here"),
        result("stop it", "stop", file="e", kind="near-miss"),
    ]
    there = [
        result("stop", "stop", file="c"),
        result("stop", "stop", file="a"),
        result("stop", file="b"),
        result("stop", file="d", snr=5.0),
        result("stop it", file="e", kind="near-miss"),
        result("stop", file="only here", error="no file"),
    ]
    assert compare(here, there) == [
        Difference("mine", None, 3, 0.66667, 0.66667, 1, 1, 1.0),
        Difference("mine", 5.0, 1, 1.0, 0.0, 1, 0, 1.0),
    ]


def test_stretches_of_a_stream_are_paired_by_where_they_begin(result: Any) -> None:
    stream = {"file": "stream", "set": "mine"}
    here = [result("stop", "stop", start=1.0, **stream), result("stop", start=5.0, **stream)]
    there = [result("stop", start=5.0, **stream), result("stop", "stop", start=1.0, **stream)]
    assert compare(here, there) == [Difference("mine", None, 2, 0.5, 0.5, 0, 0, 1.0)]


def test_only_the_same_noise_is_compared(result: Any) -> None:
    tap, motor = (result("stop", "stop", snr=5.0, noise=name) for name in ("tap", "motor"))
    assert compare([tap], [motor]) == []
    assert len(compare([tap], [tap])) == 1


def test_alarms_are_counted_in_what_both_have_heard(result: Any) -> None:
    talk = {"kind": "talk", "seconds": 1800.0}
    here = [result("a", "stop", **talk), result("b", **talk), result("only here", **talk)]
    there = [result("a", **talk), result("b", **talk), result("only there", "stop", **talk)]
    assert compare_alarms(here, there) == [
        AlarmDifference("mine", "talk", None, alarm_rate(1, hours=1), alarm_rate(0, hours=1))
    ]


def test_other_sets_have_nothing_in_common(result: Any) -> None:
    assert compare([result("stop", "stop")], [result("stop", "stop", set="other")]) == []
