from __future__ import annotations

from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.path import Path
from matplotlib.transforms import Bbox

from voz.robot.simulation.label_placement import (
    NEAR_DISTANCES,
    LabelRequest,
    Points,
    hook,
    place_labels,
)

AREA = Bbox.from_extents(0, 0, 500, 300)
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
    taken, avoid = Bbox.from_extents(200, 100, 260, 140), np.reshape(points, (-1, 2))
    boxes = place_labels(wishes, avoid, [taken], AREA)
    assert len(boxes) == len(wishes)
    placed = [(wish, box) for wish, box in zip(wishes, boxes, strict=True) if box]
    for wish, box in placed:
        assert box.size == pytest.approx(wish.size)
        assert AREA.count_contains(box.corners()) == 4
        assert not box.overlaps(taken)
        if not wish.leader:
            assert not box.count_contains(avoid)
    for (wish, box), (_, other) in permutations(placed, 2):
        assert not box.overlaps(other)
        assert not (wish.leader and Path([wish.anchor, hook(box)]).intersects_bbox(other))


def test_forty_labels_along_a_way_all_find_room() -> None:
    way = np.array([(50 + 10 * n, 150 + 60 * np.sin(n / 6)) for n in range(40)])
    boxes = place_labels([LabelRequest((x, y), (40, 14), True) for x, y in way], way, [], AREA)
    placed = [box for box in boxes if box]
    assert len(placed) == 40
    assert not any(one.overlaps(other) for one, other in combinations(placed, 2))


def test_a_label_alone_is_near_what_it_names() -> None:
    (box,) = place_labels([LabelRequest((250, 150), (80, 20), False)], NOTHING, [], AREA)
    assert box
    assert box.padded(max(NEAR_DISTANCES) + 0.01).contains(250, 150)


def test_a_label_goes_where_it_covers_nothing() -> None:
    above = np.array([(x, y) for x in range(150, 350, 5) for y in range(155, 300, 5)])
    (box,) = place_labels([LabelRequest((250, 150), (80, 20), True)], above, [], AREA)
    assert box
    assert box.y1 < 155


def test_a_label_without_a_leader_is_left_out_rather_than_far_away() -> None:
    everywhere = np.array([(x, y) for x in range(0, 500, 5) for y in range(0, 300, 5)])
    wish = LabelRequest((250, 150), (80, 20), False)
    assert place_labels([wish], everywhere, [], AREA) == [None]
    assert place_labels([wish._replace(leader=True)], everywhere, [], AREA) != [None]


def test_what_is_larger_than_the_area_has_no_place() -> None:
    assert place_labels([LabelRequest((250, 150), (501, 20), True)], NOTHING, [], AREA) == [None]
    assert place_labels([], NOTHING, [], AREA) == []
