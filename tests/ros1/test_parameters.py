"""What a parameter server may hold, in place of which a dictionary stands here."""

from __future__ import annotations

import math
import sys
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.errors import ConfigError
from voz.ros1.parameters import read_settings

VALUES = st.one_of(
    st.floats(),
    st.floats(0, 1),
    st.integers(),
    st.booleans(),
    st.text(max_size=4),
    st.sampled_from(["nan", "inf", "-1", "0.5", "1e999"]),
)


@given(VALUES)
def test_no_value_from_outside_its_range_comes_from_a_parameter(value: object) -> None:
    with pytest.MonkeyPatch.context() as patch:
        held = {"~threshold": value}
        patch.setitem(sys.modules, "rospy", SimpleNamespace(get_param=held.get))
        try:
            threshold = read_settings().recognition.threshold
        except ConfigError:
            return
    assert threshold is None if str(value).strip() == "" else 0 <= float(str(value)) <= 1
    assert threshold is None or threshold == pytest.approx(float(str(value)), abs=math.ulp(1))
