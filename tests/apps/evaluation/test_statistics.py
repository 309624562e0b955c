from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.apps.evaluation.statistics import alarm_rate, estimate, mcnemar

CLIPS = st.lists(st.tuples(st.booleans(), st.sampled_from("abcde")), min_size=1, max_size=30)


@given(CLIPS)
def test_the_interval_holds_the_figure_and_stays_between_0_and_1(
    clips: list[tuple[bool, str]],
) -> None:
    right, speakers = zip(*clips, strict=True)
    figure = estimate(right, [1] * len(right), speakers)
    assert figure.value == pytest.approx(sum(right) / len(right), abs=1e-5)
    assert 0 <= figure.low <= figure.value <= figure.high <= 1


def test_the_interval_is_about_that_of_the_normal_distribution() -> None:
    speakers = [str(number) for number in range(400)]
    figure = estimate([number % 2 for number in range(400)], [1] * 400, speakers)
    assert figure.value == 0.5
    assert figure.low == pytest.approx(0.5 - 1.96 * 0.025, abs=0.005)
    assert figure.high == pytest.approx(0.5 + 1.96 * 0.025, abs=0.005)


def test_speakers_are_drawn_and_not_clips() -> None:
    right, of = [1] * 50 + [0] * 50, [1] * 100
    two = estimate(right, of, ["good"] * 50 + ["bad"] * 50)
    assert (two.low, two.value, two.high) == (0, 0.5, 1)
    one = estimate(right, of, ["one"] * 100)
    assert 0.35 < one.low < 0.5 < one.high < 0.65


def test_a_rate_counts_what_it_is_of() -> None:
    assert estimate([1, 3], [0.5, 1.5], ["a", "b"]).value == 2


def test_the_interval_is_the_same_each_time() -> None:
    figures = [estimate([1, 0, 1, 1], [1] * 4, "abcd") for _ in range(2)]
    assert figures[0] == figures[1]


@pytest.mark.parametrize(
    ("alarms", "low", "high"),
    [
        (0, 0, 3.689),
        (1, 0.0253, 5.572),
        (10, 4.795, 18.39),
        (40, 28.58, 54.47),
        (100, 81.36, 121.63),
    ],
)
def test_the_interval_of_alarms_is_the_exact_one(alarms: int, low: float, high: float) -> None:
    rate = alarm_rate(alarms, hours=1)
    assert (rate.alarms, rate.hours, rate.per_hour.value) == (alarms, 1, alarms)
    assert rate.per_hour.low == pytest.approx(low, rel=1e-3)
    assert rate.per_hour.high == pytest.approx(high, rel=1e-3)


LOG_FACTORIALS = np.array([math.lgamma(k + 1) for k in range(3001)])


@given(st.integers(1, 3000), st.floats(0.001, 1000))
def test_beyond_each_end_there_is_one_time_in_forty(alarms: int, hours: float) -> None:
    def at_most(count: int, mean: float) -> float:
        counts = np.arange(count + 1)
        return float(np.exp(counts * math.log(mean) - mean - LOG_FACTORIALS[: count + 1]).sum())

    rate = alarm_rate(alarms, hours=1).per_hour
    assert at_most(alarms, rate.high) == pytest.approx(0.025, rel=1e-2)
    assert 1 - at_most(alarms - 1, rate.low) == pytest.approx(0.025, rel=1e-2)
    assert alarm_rate(alarms, hours).per_hour.high == pytest.approx(rate.high / hours, rel=1e-3)


@pytest.mark.parametrize(
    ("only_first", "only_second", "p"),
    [
        (0, 0, 1.0),
        (1, 0, 1.0),
        (5, 5, 1.0),
        (0, 5, 0.0625),  # 2 / 2**5
        (6, 1, 0.125),  # 2 * (1 + 7) / 2**7
        (2, 10, 0.03857421875),  # 2 * (1 + 12 + 66) / 2**12
        (3000, 3000, 1.0),
    ],
)
def test_mcnemar_is_twice_the_binomial_tail(only_first: int, only_second: int, p: float) -> None:
    assert mcnemar(only_first, only_second) == p == mcnemar(only_second, only_first)
