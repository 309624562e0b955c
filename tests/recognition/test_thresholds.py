"""How sure commands must be: those that must not be missed less than others."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from voz.recognition.confidence import Model, load_models
from voz.recognition.thresholds import Thresholds, threshold_for, thresholds_of
from voz.settings import Recognition


def test_fewer_false_alarms_need_a_higher_threshold() -> None:
    model = Model(fitted_on=[], intercept=1.0, weights={}, alarms=2.0, alarm_exponent=0.5)
    asked = (0.1, 0.5, 2.0, 10.0)
    found = [threshold_for(model, alarms) for alarms in asked]
    assert found == sorted(found, reverse=True)
    assert found[asked.index(2.0)] == 0.5  # as many as there are at even odds
    # The alarms fall with the root of the odds here: four times fewer at 16 times the odds.
    assert found[asked.index(0.5)] == pytest.approx(16 / 17)


@given(st.floats(0.01, 100), st.floats(1, 100))
def test_what_must_not_be_missed_needs_less_and_all_others_the_same(
    alarms: float, cost: float
) -> None:
    model = load_models().with_network
    settings = Recognition(false_alarms_per_hour=alarms, missed_cost=cost)
    needed = thresholds_of(model, settings)
    assert 0 <= needed.never_missed <= needed.usual <= 1
    odds = [p / (1 - p) for p in (needed.never_missed, needed.usual)]
    assert odds[1] == pytest.approx(cost * odds[0])
    cheaper = thresholds_of(model, replace(settings, missed_cost=1.0))
    assert cheaper.usual == needed.usual == pytest.approx(cheaper.never_missed)


@given(st.floats(0, 1))
def test_a_threshold_that_is_given_is_that_of_every_command(threshold: float) -> None:
    model = load_models().with_network
    needed = thresholds_of(model, Recognition(threshold=threshold, missed_cost=50))
    assert needed == Thresholds(threshold, threshold)
