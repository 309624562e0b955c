"""Distances of a round robot from four walls and a table."""

from __future__ import annotations

from math import hypot
from typing import NamedTuple


class Tabletop(NamedTuple):
    """A rectangle along the walls: its corner nearest to the origin and its sizes, m."""

    x: float
    y: float
    width: float
    depth: float

    def holds(self, x: float, y: float) -> bool:
        """Whether a point is on it."""
        return self.x <= x <= self.x + self.width and self.y <= y <= self.y + self.depth


def gap_to_walls(x: float, y: float, radius: float, room: tuple[float, float]) -> float:
    """Distance from a circle to the nearest wall, m; below 0 it is in the wall."""
    return min(x, room[0] - x, y, room[1] - y) - radius


def gap_to_table(x: float, y: float, radius: float, table: Tabletop) -> float:
    """Distance from a circle to the table, m; below 0 it is in the table."""
    beside_x = max(table.x - x, 0.0, x - table.x - table.width)
    beside_y = max(table.y - y, 0.0, y - table.y - table.depth)
    return hypot(beside_x, beside_y) - radius
