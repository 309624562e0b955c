"""What a rate of false alarms costs, between the rates that were looked at."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.recognition.confidence_model import Model, load_models
from voz.recognition.miss_rates import MissRate, alarm_rates_near, miss_rate_at

COSTS = (MissRate(0.1, 0.3), MissRate(1.0, 0.2), MissRate(10.0, 0.0))


@pytest.mark.parametrize(
    ("alarms", "missed"), [(0.1, 0.3), (10.0, 0.0), (10**-0.5, 0.25), (10**0.5, 0.1)]
)
def test_between_two_rates_the_logarithm_counts(alarms: float, missed: float) -> None:
    assert miss_rate_at(COSTS, alarms) == pytest.approx(missed)


@given(st.floats(0.1, 10), st.floats(0.1, 10))
def test_more_false_alarms_miss_fewer_commands(one: float, other: float) -> None:
    fewer, more = miss_rate_at(COSTS, min(one, other)), miss_rate_at(COSTS, max(one, other))
    assert fewer is not None
    assert more is not None
    assert fewer >= more - 1e-12


@pytest.mark.parametrize("alarms", [0.09, 10.1])
def test_beyond_what_was_looked_at_nothing_is_known(alarms: float) -> None:
    assert miss_rate_at(COSTS, alarms) is None
    assert miss_rate_at((), alarms) is None


@pytest.mark.parametrize("model", [load_models().two_ears, load_models().one_ear])
def test_what_comes_with_voz_tells_what_it_costs(model: Model) -> None:
    assert tuple(cost.alarms for cost in model.costs) == alarm_rates_near(model.usual_alarms)
    missed = [cost.missed for cost in model.costs]
    assert missed == sorted(missed, reverse=True)
    assert missed[0] > missed[-1]
