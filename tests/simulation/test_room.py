from __future__ import annotations

from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.simulation.room import Tabletop, gap_to_table, gap_to_walls

TABLE = Tabletop(1.0, 2.0, 0.5, 1.5)
places = st.tuples(st.floats(0, 4), st.floats(0, 4))


def test_the_nearest_wall_counts() -> None:
    room = (4.0, 3.0)
    gaps = [gap_to_walls(x, y, 0.2, room) for x, y in [(1, 1.5), (3.5, 1.5), (2, 2.9), (2, 0.1)]]
    assert gaps == pytest.approx([0.8, 0.3, -0.1, -0.1])


def test_the_nearest_edge_or_corner_of_the_table_counts() -> None:
    gaps = [gap_to_table(x, y, 0.1, TABLE) for x, y in [(0.5, 3), (2, 3), (1.2, 1), (0.7, 1.6)]]
    assert gaps == pytest.approx([0.4, 0.4, 0.9, 0.4])
    assert gap_to_table(1.2, 2.5, 0.1, TABLE) == pytest.approx(-0.1)


@given(places, st.floats(0, 1), st.floats(0, 1))
def test_no_point_of_the_table_is_nearer_than_the_gap(
    place: tuple[float, float], along: float, across: float
) -> None:
    corner = (TABLE.x + TABLE.width * along, TABLE.y + TABLE.depth * across)
    away = hypot(corner[0] - place[0], corner[1] - place[1])
    assert away >= gap_to_table(*place, 0.0, TABLE) - 1e-12
    assert TABLE.holds(*place) == (gap_to_table(*place, 0.0, TABLE) == 0)
