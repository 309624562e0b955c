from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.apps.evaluation.curves import (
    CurvePoint,
    ReliabilityBin,
    confusion,
    curves,
    operating_curve,
    reliability,
)

CONFIDENCES = st.lists(st.integers(0, 20).map(lambda n: n / 20), min_size=1, max_size=20)


def test_each_confidence_is_a_threshold() -> None:
    curve = operating_curve([0.9, 0.8, 0.4, 0.4], [0.8, 0.1])
    assert curve.points == [
        CurvePoint(0.9, 0.25, 0.0),
        CurvePoint(0.8, 0.5, 0.5),
        CurvePoint(0.4, 1.0, 0.5),
        CurvePoint(0.1, 1.0, 1.0),
    ]
    # Of 8 pairs 5 are in the right order (0.9 twice, 0.8, 0.4 and 0.4 above 0.1), one is a tie.
    assert curve.area == 5.5 / 8


@given(CONFIDENCES, CONFIDENCES)
def test_the_area_is_how_often_a_command_is_surer(
    commands: list[float], others: list[float]
) -> None:
    wins = [(c > o) + (c == o) / 2 for c in commands for o in others]
    assert operating_curve(commands, others).area == pytest.approx(sum(wins) / len(wins), abs=1e-5)


@given(CONFIDENCES, CONFIDENCES)
def test_a_lower_threshold_lets_more_through(commands: list[float], others: list[float]) -> None:
    points = operating_curve(commands, others).points
    hits, false_alarms = [p.hits for p in points], [p.false_alarms for p in points]
    assert (hits, false_alarms) == (sorted(hits), sorted(false_alarms))
    assert (hits[-1], false_alarms[-1]) == (1, 1)


def test_reliability_in_bins_of_a_tenth() -> None:
    curve = reliability([(0.95, True), (1.0, True), (0.92, False), (0.05, False), (0.1, True)])
    third = pytest.approx(2 / 3, abs=1e-5)
    assert curve.bins[0] == ReliabilityBin(0.05, 0, 1)
    assert curve.bins[1] == ReliabilityBin(0.1, 1, 1)
    assert (curve.bins[2].right, curve.bins[2].utterances) == (third, 3)
    off = 0.05 * 1 + 0.9 * 1 + abs(2.87 / 3 - 2 / 3) * 3
    assert curve.expected_error == pytest.approx(off / 5, abs=1e-4)


def test_confusion_has_a_column_for_refused_and_one_for_nothing() -> None:
    pairs = [("stop", "stop"), ("stop", "(refused)"), ("go", "stop"), ("go", "(nothing)")]
    matrix = confusion([*pairs, ("go", "fold arm")])
    assert matrix.said == ["go", "stop"]
    assert matrix.heard == ["go", "stop", "fold arm", "(refused)", "(nothing)"]
    assert matrix.counts == [[0, 1, 1, 0, 1], [0, 1, 0, 1, 0]]


def test_what_the_curves_are_drawn_from(result: Any) -> None:
    drawn = curves(
        [
            result("stop", "stop", confidence=0.9),
            result("stop", "go back?", confidence=0.2),
            result("stop", "stop", confidence=0.1, snr=5.0),
            result("stop", error="no file"),
            result("stop it", "stop?", confidence=0.3, kind="near-miss"),
            result("hello", kind="near-miss"),
            result("stop | stop", "stop", kind="long"),
        ]
    )
    assert drawn.operating
    assert [p.threshold for p in drawn.operating.points] == [0.9, 0.3, 0]
    assert drawn.reliability
    assert [(b.right, b.utterances) for b in drawn.reliability.bins] == [(0, 1), (0, 1), (1, 1)]
    assert drawn.confusion
    assert drawn.confusion.counts == [[1, 1, 0]]


def test_without_clips_there_are_no_curves() -> None:
    drawn = curves([])
    assert drawn.operating is drawn.reliability is drawn.confusion is None
