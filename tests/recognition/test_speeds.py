"""Sound at other speeds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.audio import SAMPLE_RATE
from voz.recognition.speeds import at_speed, mean_odds


@pytest.mark.parametrize("speed", [0.89, 1.12])
def test_sound_at_another_speed_is_higher_and_shorter_by_as_much(speed: float) -> None:
    tone = np.sin(2 * np.pi * 500 * np.arange(SAMPLE_RATE) / SAMPLE_RATE)
    played = at_speed((10000 * tone).astype(np.int16), speed)
    assert played.dtype == np.int16
    assert len(played) == pytest.approx(SAMPLE_RATE / speed, abs=2)
    loudest = np.abs(np.fft.rfft(played)).argmax() * SAMPLE_RATE / len(played)
    assert loudest == pytest.approx(500 * speed, abs=2)


@given(st.lists(st.floats(-50, 50), min_size=1))
def test_the_mean_of_odds_is_that_of_their_exponentials(log_odds: list[float]) -> None:
    expected = math.log(sum(map(math.exp, log_odds)) / len(log_odds))
    assert mean_odds(log_odds) == pytest.approx(expected)
    assert min(log_odds) - 1e-9 <= mean_odds(log_odds) <= max(log_odds) + 1e-9


def test_odds_of_nothing_add_nothing() -> None:
    assert mean_odds([0.0, -math.inf]) == pytest.approx(-math.log(2))
