"""What was heard where: the rule by which streams are scored."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.apps.evaluation.results import Understood
from voz.apps.evaluation.stretches import assign_to_stretches, seconds_outside


def heard(start: float, end: float) -> Understood:
    return Understood("stop", 1.0, accepted=True, start=start, end=end)


@pytest.mark.parametrize(
    ("start", "end", "belongs"),
    [
        (1.2, 1.8, 0),
        (0.0, 9.0, 0),  # a whole recording taken for one utterance
        (0.5, 1.1, 0),
        (1.9, 2.5, 0),
        (1.9, 4.5, 0),
        (2.0, 4.0, None),  # touches both
        (3.9, 4.1, 1),
        (6.0, 7.0, None),
    ],
)
def test_an_utterance_belongs_to_the_first_stretch_that_it_overlaps(
    start: float, end: float, belongs: int | None
) -> None:
    utterance = heard(start, end)
    parts, rest = assign_to_stretches([utterance], [(1.0, 2.0), (4.0, 5.0)])
    assert parts == [[utterance] if n == belongs else [] for n in range(2)]
    assert rest == ([] if belongs is not None else [utterance])


TIMES = st.tuples(st.integers(0, 30), st.integers(1, 9)).map(lambda t: (t[0], t[0] + t[1]))


@given(st.lists(TIMES, max_size=8, unique=True), st.lists(TIMES, max_size=8))
def test_nothing_is_lost_and_the_order_of_the_list_does_not_matter(
    stretches: list[tuple[int, int]], utterances: list[tuple[int, int]]
) -> None:
    said = [heard(*times) for times in utterances]
    parts, rest = assign_to_stretches(said, stretches)
    backwards, same_rest = assign_to_stretches(said, stretches[::-1])
    assert backwards[::-1] == parts
    assert same_rest == rest
    assert sorted(u.start for u in said) == sorted(u.start for p in [*parts, rest] for u in p)


@given(st.lists(TIMES, max_size=8))
def test_the_time_outside_is_what_no_stretch_covers(stretches: list[tuple[int, int]]) -> None:
    covered = {second for start, end in stretches for second in range(start, end)}
    assert seconds_outside(stretches, 25) == sum(n not in covered for n in range(25))
