"""All ways to spread a sequence over the moments add up: compared with trying every one."""

from __future__ import annotations

from itertools import groupby, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.recognition.ctc import lattice, log_likelihoods

BLANK = 2
SYMBOLS = 3


def tried(probabilities: np.ndarray, sequence: list[int]) -> float:
    total = 0.0
    for path in product(range(SYMBOLS), repeat=len(probabilities)):
        if [symbol for symbol, _ in groupby(path) if symbol != BLANK] == sequence:
            total += float(
                np.prod([row[symbol] for row, symbol in zip(probabilities, path, strict=True)])
            )
    return total


@given(
    st.lists(st.lists(st.integers(0, 1), min_size=1, max_size=4), min_size=1, max_size=4),
    st.integers(1, 6),
    st.integers(0, 2**32 - 1),
)
def test_it_is_the_sum_over_all_paths(sequences: list[list[int]], moments: int, seed: int) -> None:
    chance = np.random.default_rng(seed).random((moments, SYMBOLS)) + 0.01
    probabilities = chance / chance.sum(axis=1, keepdims=True)
    found = np.exp(log_likelihoods(probabilities, lattice(sequences, BLANK)))
    assert found == pytest.approx([tried(probabilities, one) for one in sequences], abs=1e-12)


def test_a_long_stream_is_no_matter_of_small_numbers() -> None:
    probabilities = np.full((5000, SYMBOLS), 1e-8)
    (found,) = log_likelihoods(probabilities, lattice([[0, 1, 0]], BLANK))
    assert -5000 * 18.5 < found < -5000 * 18
