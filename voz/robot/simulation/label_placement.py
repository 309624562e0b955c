"""Places labels so that none covers another: pure geometry, in units of 1/72 inch.

adjustText needs scipy, and of 20 labels along a way it leaves 19 pairs one over the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from math import cos, inf, pi, prod, sin
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

Points: TypeAlias = npt.NDArray[np.float64]
"""Places, one in each row."""

Position: TypeAlias = tuple[float, float]

DISTANCES = (12, 20, 32, 48, 70, 95, 125, 160, 200, 250)
"""Distances of a label with a leader from its anchor."""

NEAR_DISTANCES = (4, 6)
"""The same for a label without."""

DIRECTIONS = 24
"""Number of directions from the anchor that are tried."""

COVERED_COST, CROSSED_COST, MISSING_COST = 12, 60, 10_000
"""Costs, as distances: a covered point, a crossed leader or anchor, a missing label."""

COVER_MARGIN, ANCHOR_MARGIN = 4, 10
"""Points nearer to a label or its leader are covered, unless they are nearer to its anchor."""

LAYOUT_ROUNDS = 3
"""Times that each label looks for a better place among the others."""

MAX_HOOK_OFFSET = 20
"""Largest distance from the corner of a label to the end of its leader."""


class Rectangle(NamedTuple):
    """A rectangle by its four sides."""

    left: float
    bottom: float
    right: float
    top: float

    def holds(self, points: Points) -> npt.NDArray[np.bool_]:
        """Return which points are in it."""
        x, y = points[:, 0], points[:, 1]
        inside: npt.NDArray[np.bool_] = (
            (x > self.left) & (x < self.right) & (y > self.bottom) & (y < self.top)
        )
        return inside

    def meets(self, other: Rectangle) -> bool:
        """Whether they overlap."""
        return (
            self.left < other.right
            and other.left < self.right
            and self.bottom < other.top
            and other.bottom < self.top
        )

    def is_within(self, other: Rectangle) -> bool:
        """Whether it is completely inside another."""
        return (
            other.left <= self.left
            and self.right <= other.right
            and other.bottom <= self.bottom
            and self.top <= other.top
        )

    def grown(self, by: float) -> Rectangle:
        """Return a larger rectangle, with `by` more on each side."""
        return Rectangle(self.left - by, self.bottom - by, self.right + by, self.top + by)

    def hook(self) -> Position:
        """Return where its leader ends: near the beginning of the first line."""
        width, height = self.right - self.left, self.top - self.bottom
        return self.left + min(width / 2, MAX_HOOK_OFFSET), self.top - min(
            height / 2, MAX_HOOK_OFFSET / 2
        )


class LabelRequest(NamedTuple):
    """A label that needs a place."""

    anchor: Position  # the place that it describes
    size: tuple[float, float]  # its width and height
    # Whether a line leads from it to its anchor; else it must be near and cover nothing.
    leader: bool


class LabelOption(NamedTuple):
    """A place that a label may have, and what it costs."""

    cost: float
    box: Rectangle
    leader: Points  # points of the line to it, if there is one
    around: Rectangle  # a box around both

    def excludes(self, other: LabelOption) -> bool:
        """Whether one would cover the other, or its leader."""
        return self.around.meets(other.around) and (
            self.box.meets(other.box)
            or bool(self.box.holds(other.leader).any())
            or bool(other.box.holds(self.leader).any())
        )


def place_labels(
    wishes: Sequence[LabelRequest], avoid: Points, taken: Sequence[Rectangle], area: Rectangle
) -> list[Rectangle | None]:
    """Find a place in an area for each label near its anchor; None where there is no room.

    Labels do not overlap, nor does a leader cross another label. The points to avoid should not be
    covered; where it is taken no label may be.
    """
    anchors = np.reshape([wish.anchor for wish in wishes], (-1, 2))
    options = [
        [o for o in _options(wish, anchors, avoid, area) if not any(map(o.box.meets, taken))]
        for wish in wishes
    ]
    numbers = range(len(wishes))
    # Those that must be near come first; for the others no order is always best.
    orders = (
        sorted(numbers, key=lambda i: (wishes[i].leader, -prod(wishes[i].size))),
        sorted(numbers, key=lambda i: (wishes[i].leader, i)),
        sorted(numbers, key=lambda i: (wishes[i].leader, -i)),
    )
    layouts = [_layout(options, order) for order in orders]
    return [option and option.box for option in min(layouts, key=_total)]


def _options(
    wish: LabelRequest, anchors: Points, avoid: Points, area: Rectangle
) -> list[LabelOption]:
    """List the places that a label may have, the best first."""
    strange = anchors[np.abs(anchors - wish.anchor).max(axis=1) > ANCHOR_MARGIN]
    options = [
        _option(wish, box, distance + _harm(wish, box, strange, avoid))
        for distance, box in _around(wish)
        if box.is_within(area)
    ]
    allowed = inf if wish.leader else COVERED_COST
    return sorted((o for o in options if o.cost < allowed), key=lambda option: option.cost)


def _option(wish: LabelRequest, box: Rectangle, cost: float) -> LabelOption:
    leader = _leader(wish, box)
    (left, bottom), (right, top) = leader.min(axis=0, initial=inf), leader.max(axis=0, initial=-inf)
    around = Rectangle(
        min(left, box.left), min(bottom, box.bottom), max(right, box.right), max(top, box.top)
    )
    return LabelOption(cost, box, leader, around)


def _around(wish: LabelRequest) -> Iterator[tuple[float, Rectangle]]:
    (x, y), (width, height) = wish.anchor, wish.size
    for distance in DISTANCES if wish.leader else NEAR_DISTANCES:
        for angle in (2 * pi * direction / DIRECTIONS for direction in range(DIRECTIONS)):
            left = x + cos(angle) * (distance + width / 2) - width / 2
            bottom = y + sin(angle) * (distance + height / 2) - height / 2
            yield distance, Rectangle(left, bottom, left + width, bottom + height)


def _harm(wish: LabelRequest, box: Rectangle, strange: Points, avoid: Points) -> float:
    """Rate what a label and its leader would cover: anchors of others, and points to avoid."""
    with_air, leader = box.grown(COVER_MARGIN if wish.leader else 0), _leader(wish, box)
    near = np.abs(leader - wish.anchor).max(axis=1, initial=0) < ANCHOR_MARGIN
    covered = int(with_air.holds(avoid).sum()) + _touched(leader[~near], avoid)
    crossed = int(with_air.holds(strange).sum()) + _touched(leader, strange)
    return COVERED_COST * covered + CROSSED_COST * crossed


def _leader(wish: LabelRequest, box: Rectangle) -> Points:
    if not wish.leader:
        return np.empty((0, 2))
    return np.linspace(wish.anchor, box.hook(), 25, dtype=np.float64)


def _touched(leader: Points, places: Points) -> int:
    if not (len(leader) and len(places)):
        return 0
    low, high = leader.min(axis=0), leader.max(axis=0)
    near = places[Rectangle(*low, *high).grown(COVER_MARGIN).holds(places)]
    away = np.abs(leader[:, np.newaxis] - near).max(axis=2)
    return int((away < COVER_MARGIN).any(axis=1).sum())


def _layout(
    options: Sequence[Sequence[LabelOption]], order: Sequence[int]
) -> list[LabelOption | None]:
    """Let each label take its best place, and choose again when all others have one."""
    chosen: list[LabelOption | None] = [None] * len(options)
    for _ in range(LAYOUT_ROUNDS):
        for index in order:
            others = [o for n, o in enumerate(chosen) if o and n != index]
            chosen[index] = _best(options[index], others)
    return chosen


def _best(options: Sequence[LabelOption], others: Sequence[LabelOption]) -> LabelOption | None:
    least, best = inf, None
    for option in options:
        if option.cost >= least:
            break
        if not any(option.excludes(other) for other in others):
            cost = option.cost + CROSSED_COST * sum(_cross(option, o) for o in others)
            if cost < least:
                least, best = cost, option
    return best


def _total(layout: Sequence[LabelOption | None]) -> float:
    placed = [option for option in layout if option]
    crossed = sum(_cross(a, b) for a, b in combinations(placed, 2))
    missing = len(layout) - len(placed)
    return sum(o.cost for o in placed) + CROSSED_COST * crossed + MISSING_COST * missing


def _cross(option: LabelOption, another: LabelOption) -> bool:
    """Whether the leaders of two labels cross."""
    one, other = option.leader, another.leader
    if not (len(one) and len(other) and option.around.meets(another.around)):
        return False

    def side(line: Points, point: npt.NDArray[np.float64]) -> float:
        (ax, ay), (bx, by) = line[-1] - line[0], point - line[0]
        return float(ax * by - ay * bx)

    apart = side(one, other[0]) * side(one, other[-1])
    return apart <= 0 and side(other, one[0]) * side(other, one[-1]) <= 0
