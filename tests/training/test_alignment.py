"""Where known phones are said, beside all paths that there are."""

from __future__ import annotations

from itertools import groupby, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from training_programs import load_training

BLANK = 0


alignment = load_training("alignment")


def phones_of(path: tuple[int, ...]) -> list[int]:
    return [symbol for symbol, _ in groupby(path) if symbol != BLANK]


@given(
    st.integers(0, 2**32 - 1),
    st.lists(st.integers(1, 3), min_size=1, max_size=3),
    st.integers(1, 6),
)
def test_the_alignment_is_the_likeliest_of_all_paths(
    seed: int, phones: list[int], moments: int
) -> None:
    likely = np.log(np.random.default_rng(seed).dirichlet(np.ones(4), moments))
    paths = [path for path in product(range(4), repeat=moments) if phones_of(path) == phones]
    with_another = np.stack([likely, np.log(np.full(likely.shape, 0.25))])
    spans, _ = alignment.align(with_another, [phones, [1, 2, 3, 1]])
    if not paths:
        assert spans == []
        return
    best = max(paths, key=lambda path: sum(likely[t, symbol] for t, symbol in enumerate(path)))
    found = [BLANK] * moments
    for phone, (first, last) in zip(phones, spans, strict=True):
        assert first <= last
        found[first : last + 1] = [phone] * (last + 1 - first)
    score = sum(likely[t, symbol] for t, symbol in enumerate(found))
    assert phones_of(tuple(found)) == phones
    assert score == pytest.approx(sum(likely[t, symbol] for t, symbol in enumerate(best)))


def test_a_stretch_holds_the_phones_within_it_unless_one_is_cut() -> None:
    spans, phones = [(5, 6), (10, 10), (20, 22)], ["S", "T", "AA"]
    assert alignment.phones_within(spans, phones, 0, 30) == ("S", "T", "AA")
    assert alignment.phones_within(spans, phones, 0, 15) == ("S", "T")
    assert alignment.phones_within(spans, phones, 0, 21) is None  # AA is cut
    assert alignment.phones_within(spans, phones, 11, 15) is None  # T may be in it or not
    assert alignment.phones_within(spans, phones, 13, 17) is None  # there is none in it
