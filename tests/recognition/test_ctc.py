"""All ways to spread and to pronounce a sentence add up: compared with trying every one."""

from __future__ import annotations

from itertools import chain, groupby, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.recognition.ctc import lattice, log_likelihoods

BLANK = 2
SYMBOLS = 3

Sentence = list[list[list[int]]]

WAYS = st.lists(
    st.lists(st.integers(0, 1), min_size=1, max_size=3), min_size=1, max_size=2, unique_by=tuple
)
SENTENCES = st.lists(st.lists(WAYS, min_size=1, max_size=3), min_size=1, max_size=4)


def tried(probabilities: np.ndarray, sentence: Sentence) -> float:
    """Each choice of its words' ways counts, also where two of them sound the same."""
    total = 0.0
    said = [list(chain(*ways)) for ways in product(*sentence)]
    for path in product(range(SYMBOLS), repeat=len(probabilities)):
        heard = [symbol for symbol, _ in groupby(path) if symbol != BLANK]
        chance = np.prod([row[symbol] for row, symbol in zip(probabilities, path, strict=True)])
        total += said.count(heard) * float(chance)
    return total


@given(SENTENCES, st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_it_is_the_sum_over_all_paths(sentences: list[Sentence], moments: int, seed: int) -> None:
    chance = np.random.default_rng(seed).random((moments, SYMBOLS)) + 0.01
    probabilities = chance / chance.sum(axis=1, keepdims=True)
    found = np.exp(log_likelihoods(probabilities, lattice(sentences, BLANK)))
    assert found == pytest.approx([tried(probabilities, one) for one in sentences], abs=1e-12)


def test_a_long_stream_is_no_matter_of_small_numbers() -> None:
    probabilities = np.full((5000, SYMBOLS), 1e-8)
    (found,) = log_likelihoods(probabilities, lattice([[[[0, 1, 0]]]], BLANK))
    assert -5000 * 18.5 < found < -5000 * 18
