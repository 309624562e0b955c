"""How sure commands must be: those that must not be missed less than others."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from voz.recognition.confidence import Model, load_models
from voz.recognition.thresholds import threshold_for, thresholds
from voz.settings import Recognition

COMMANDS = ["stop", "go back", "turn left"]


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
    needed = thresholds(model, settings, COMMANDS)
    assert list(needed) == COMMANDS
    assert 0 <= needed["stop"] <= needed["go back"] == needed["turn left"] <= 1
    cheaper = thresholds(model, replace(settings, missed_cost=1.0), COMMANDS)
    assert cheaper["go back"] == needed["go back"]
    assert cheaper["stop"] == pytest.approx(cheaper["go back"])


@given(st.floats(0, 1))
def test_a_threshold_that_is_given_is_that_of_every_command(threshold: float) -> None:
    model = load_models().with_network
    needed = thresholds(model, Recognition(threshold=threshold, missed_cost=50), COMMANDS)
    assert needed == dict.fromkeys(COMMANDS, threshold)
