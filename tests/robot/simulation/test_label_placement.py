from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from voz.robot.simulation.label_placement import (
    NEAR_DISTANCES,
    LabelRequest,
    Points,
    Rectangle,
    place_labels,
)

AREA = Rectangle(0, 0, 500, 300)
NOTHING: Points = np.empty((0, 2))

wishes = st.builds(
    LabelRequest,
    st.tuples(st.floats(0, 500), st.floats(0, 300)),
    st.tuples(st.floats(10, 120), st.floats(8, 90)),
    st.booleans(),
)


@given(st.lists(wishes, max_size=12), st.lists(st.tuples(st.floats(0, 500), st.floats(0, 300))))
@settings(max_examples=40)
def test_labels_never_cover_each_other_or_what_is_taken(
    wishes: list[LabelRequest], points: list[tuple[float, float]]
) -> None:
    taken, avoid = Rectangle(200, 100, 260, 140), np.reshape(points, (-1, 2))
    boxes = place_labels(wishes, avoid, [taken], AREA)
    assert len(boxes) == len(wishes)
    placed = [(wish, box) for wish, box in zip(wishes, boxes, strict=True) if box]
    for wish, box in placed:
        assert (box.right - box.left, box.top - box.bottom) == pytest.approx(wish.size)
        assert box.is_within(AREA)
        assert not box.meets(taken)
        if not wish.leader:
            assert not box.holds(avoid).any()
    for (wish, box), (_, other) in permutations(placed, 2):
        assert not box.meets(other)
        leader = np.linspace(wish.anchor, box.hook(), 25)
        assert not (wish.leader and other.holds(leader).any())


def test_a_label_alone_is_near_what_it_names() -> None:
    (box,) = place_labels([LabelRequest((250, 150), (80, 20), False)], NOTHING, [], AREA)
    assert box
    assert box.grown(max(NEAR_DISTANCES)).holds(np.array([[250, 150]])).all()


def test_a_label_goes_where_it_covers_nothing() -> None:
    above = np.array([(x, y) for x in range(150, 350, 5) for y in range(155, 300, 5)])
    (box,) = place_labels([LabelRequest((250, 150), (80, 20), True)], above, [], AREA)
    assert box
    assert box.top < 155


def test_a_label_without_a_leader_is_left_out_rather_than_far_away() -> None:
    everywhere = np.array([(x, y) for x in range(0, 500, 5) for y in range(0, 300, 5)])
    wish = LabelRequest((250, 150), (80, 20), False)
    assert place_labels([wish], everywhere, [], AREA) == [None]
    assert place_labels([wish._replace(leader=True)], everywhere, [], AREA) != [None]


def test_what_is_larger_than_the_area_has_no_place() -> None:
    assert place_labels([LabelRequest((250, 150), (501, 20), True)], NOTHING, [], AREA) == [None]
    assert place_labels([], NOTHING, [], AREA) == []
