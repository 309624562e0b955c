from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from voz.sequences import shared_ends

LETTERS = st.lists(st.sampled_from("ab"), max_size=6)


@given(LETTERS, LETTERS)
def test_what_is_shared_is_the_same_and_what_is_next_to_it_is_not(
    one: list[str], other: list[str]
) -> None:
    begin, end = shared_ends(one, other)
    assert one[:begin] == other[:begin]
    assert one[len(one) - end :] == other[len(other) - end :]
    first, second = one[begin : len(one) - end], other[begin : len(other) - end]
    if first and second:
        assert first[0] != second[0]
        assert first[-1] != second[-1]
