"""The table of phone distances that comes with voz."""

from __future__ import annotations

from itertools import permutations

import pytest

from voz.language.phone_distances import read_distances
from voz.language.pronunciation import PHONE_NAMES


def test_every_phone_has_a_length_and_a_distance_to_every_other():
    distances = read_distances()
    every = PHONE_NAMES.split()
    assert list(distances.frames) == list(distances.apart) == every
    assert all(list(distances.apart[phone]) == every for phone in every)


def test_phones_are_apart_from_all_others_and_equally_in_both_directions():
    apart = read_distances().apart
    assert all(apart[phone][phone] == 0 for phone in apart)
    assert all(apart[p][q] == apart[q][p] > 0 for p, q in permutations(apart, 2))


@pytest.mark.parametrize(("near", "far"), [("S Z", "S AA"), ("EH AE", "EH K"), ("M N", "M AY")])
def test_phones_that_are_made_alike_are_near(near: str, far: str):
    apart = read_distances().apart
    (p, q), (r, s) = near.split(), far.split()
    assert apart[p][q] < apart[r][s]
