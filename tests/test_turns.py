"""Tests that wait and tests that compute come by turns, whatever there is of each."""

from __future__ import annotations

from itertools import groupby

from hypothesis import given
from hypothesis import strategies as st
from turns import by_turns

ORDER = [("a", False), ("a", False), ("b", False), ("b", False), ("m", True), ("n", True)]


def ordered(tests: list[tuple[str, bool]]) -> list[tuple[str, bool]]:
    files, waits = [file for file, _ in tests], [each for _, each in tests]
    return [tests[number] for number in by_turns(files, waits)]


def test_what_waits_is_spread_among_what_does_not() -> None:
    assert [file for file, _ in ordered(ORDER)] == ["a", "a", "m", "b", "b", "n"]


@given(st.lists(st.tuples(st.integers(1, 9), st.booleans()), max_size=12))
def test_nothing_is_lost_and_a_file_stays_together(sizes: list[tuple[int, bool]]) -> None:
    tests = [(f"{n:02}", waits) for n, (size, waits) in enumerate(sizes) for _ in range(size)]
    after = ordered(tests)
    assert sorted(after) == tests
    files = [file for file, _ in groupby(after)]
    assert len(files) == len(sizes)
    for kind in (True, False):  # each in the order that it had
        assert [test for test in after if test[1] == kind] == [t for t in tests if t[1] == kind]
