from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from voz.recognition.confidence import MIDDLE, confidence

ratios = st.floats(allow_nan=False)


@given(ratios)
def test_it_is_between_0_and_1(ratio: float) -> None:
    assert 0 <= confidence(ratio) <= 1


@given(ratios, ratios)
def test_a_better_ratio_is_never_less_sure(one: float, other: float) -> None:
    low, high = sorted([one, other])
    assert confidence(low) <= confidence(high)


def test_its_ends_and_its_middle() -> None:
    assert confidence(-math.inf) == 0
    assert confidence(math.inf) == 1
    assert confidence(MIDDLE) == 0.5
