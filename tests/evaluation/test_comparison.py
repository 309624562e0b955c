from __future__ import annotations

from typing import Any

from voz.evaluation.comparison import Difference, compare


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


def test_other_sets_have_nothing_in_common(result: Any) -> None:
    assert compare([result("stop", "stop")], [result("stop", "stop", set="other")]) == []
