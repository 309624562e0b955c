"""Quantiles, beside numpy's."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import FIXTURES

from voz.audio.quantile import quantile


@given(
    values=st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=40),
    columns=st.integers(1, 3),
    share=st.floats(0, 1),
)
def test_they_are_those_of_numpy(values: list[float], columns: int, share: float) -> None:
    table = np.array([values] * columns).T
    found, expected = quantile(table, share), np.quantile(table, share, axis=0)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-6)
    assert quantile(values, share) == pytest.approx(found[0])


def test_to_understand_a_recording_loads_neither_masked_arrays_nor_openssl() -> None:
    recording = FIXTURES / "commands" / "festival_slt__go_forward.flac"
    program = "import sys, voz; print(*voz.load().decode(sys.argv[1])); print(*sys.modules)"
    told = subprocess.check_output([sys.executable, "-c", program, recording], timeout=120)
    assert b"go forward" in told
    assert not {b"numpy.ma", b"_hashlib"} & {*told.split()}
