"""How far the phones that were heard are from those of a command."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from voz.language.confusion import read_distances
from voz.recognition.alignment import ADDED, LONGEST_ADDED, SKIPPED, distance

PHONES = sorted(read_distances().frames)
heard_phones = st.lists(st.tuples(st.sampled_from(PHONES), st.integers(3, 40)), max_size=8)
said_phones = st.lists(st.sampled_from(PHONES), max_size=8)


def test_what_was_said_has_no_distance() -> None:
    assert distance(["S", "T", "AA", "P"], [("S", 12), ("T", 6), ("AA", 18), ("P", 9)]) == 0


def test_alike_phones_are_closer_than_others() -> None:
    vowel, hiss = (distance(["AA"], [(phone, 10)]) for phone in ("AO", "S"))
    assert 0 < vowel < hiss


def test_a_phone_that_is_missing_or_too_many_costs() -> None:
    frames = read_distances().frames
    assert distance(["S"], []) == SKIPPED * frames["S"]
    assert distance([], [("S", 4)]) == ADDED * 4
    assert distance([], [("S", 90)]) == ADDED * LONGEST_ADDED


@given(said_phones, heard_phones)
def test_it_is_never_less_than_nothing_nor_more_than_all_anew(
    said: list[str], heard: list[tuple[str, int]]
) -> None:
    anew = distance(said, []) + distance([], heard)
    assert 0 <= distance(said, heard) <= anew + 1e-9
