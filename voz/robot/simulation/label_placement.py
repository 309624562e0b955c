"""Places labels so that none covers another, in units of 1/72 inch. Needs matplotlib.

Each takes the best free place around its anchor. adjustText needs scipy, and of 20 labels along a
way it leaves 19 pairs one over the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import islice
from math import cos, inf, pi, sin
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from matplotlib.path import Path
from matplotlib.transforms import Bbox

Points: TypeAlias = npt.NDArray[np.float64]
"""Places, one in each row."""

Position: TypeAlias = tuple[float, float]

DISTANCES = (12, 20, 32, 48, 70, 95, 125, 160, 200, 250)
"""Distances of a label with a leader from its anchor."""

NEAR_DISTANCES = (4, 6)
"""The same for a label without."""

DIRECTIONS = 24
"""Number of directions from the anchor that are tried."""

COVERED_COST, CROSSED_COST = 12, 60
"""Costs, as distances: a covered point, and a crossed leader or anchor."""

COVER_MARGIN, ANCHOR_MARGIN = 4, 10
"""Points nearer to a label or its leader are covered, unless they are nearer to its anchor."""

LAYOUT_ROUNDS = 6
"""Times that all labels are placed, so that each finds room."""

COMPARED_PLACES = 12
"""Of the free places of a label, the cheapest, of which leaders are compared."""

MAX_HOOK_OFFSET = 20
"""Largest distance from the corner of a label to the end of its leader."""


class LabelRequest(NamedTuple):
    """A label that needs a place."""

    anchor: Position  # the place that it describes
    size: tuple[float, float]  # its width and height
    # Whether a line leads from it to its anchor; else it must be near and cover nothing.
    leader: bool


class LabelPlace(NamedTuple):
    """A place that a label may have, and what it costs."""

    cost: float
    box: Bbox
    leader: Path  # the line to it; without points if there is none

    def excludes(self, other: LabelPlace) -> bool:
        """Whether one would cover the other, or its leader."""
        return bool(
            self.box.overlaps(other.box)
            or self.leader.intersects_bbox(other.box)
            or other.leader.intersects_bbox(self.box)
        )

    def cost_among(self, others: Iterable[LabelPlace]) -> float:
        """Return its cost beside others, whose leaders it may cross."""
        crossed = sum(self.leader.intersects_path(other.leader) for other in others)
        return self.cost + CROSSED_COST * crossed


def place_labels(
    wishes: Sequence[LabelRequest], avoid: Points, taken: Sequence[Bbox], area: Bbox
) -> list[Bbox | None]:
    """Find a place in an area for each label near its anchor; None where there is no room.

    Labels do not overlap, nor does a leader cross another label. The points to avoid should not be
    covered; where it is taken no label may be.
    """
    anchors = np.reshape([wish.anchor for wish in wishes], (-1, 2))
    options = [
        [
            place
            for place in _places(wish, anchors, avoid, area)
            if not place.box.count_overlaps(taken)
        ]
        for wish in wishes
    ]
    # Those that must be near come first.
    order = sorted(range(len(wishes)), key=lambda i: wishes[i].leader)
    best: dict[int, LabelPlace] = {}
    for _ in range(LAYOUT_ROUNDS):
        layout: dict[int, LabelPlace] = {}
        for number in order:
            if place := _best(options[number], [*layout.values()]):
                layout[number] = place
        best = max(best, layout, key=len)
        if len(best) == len(wishes):
            break
        order.sort(key=layout.__contains__)  # who found no room begins next time
    return [best[number].box if number in best else None for number in range(len(wishes))]


def hook(box: Bbox) -> Position:
    """Return where the leader of a label ends: near the beginning of its first line."""
    across, down = min(box.width / 2, MAX_HOOK_OFFSET), min(box.height / 2, MAX_HOOK_OFFSET / 2)
    return box.x0 + across, box.y1 - down


def _best(options: Iterable[LabelPlace], others: Sequence[LabelPlace]) -> LabelPlace | None:
    free = (place for place in options if not any(map(place.excludes, others)))
    compared = islice(free, COMPARED_PLACES)
    return min(compared, key=partial(LabelPlace.cost_among, others=others), default=None)


def _places(wish: LabelRequest, anchors: Points, avoid: Points, area: Bbox) -> list[LabelPlace]:
    """List the places that a label may have, the best first."""
    strange = anchors[np.abs(anchors - wish.anchor).max(axis=1) > ANCHOR_MARGIN]
    places = []
    for distance, box in _around(wish):
        if area.count_contains(box.corners()) == len(box.corners()):
            line = np.linspace(wish.anchor, hook(box), 25) if wish.leader else np.empty((0, 2))
            away = line[np.abs(line - wish.anchor).max(axis=1, initial=0) >= ANCHOR_MARGIN]
            padded = box.padded(COVER_MARGIN) if wish.leader else box
            covered = padded.count_contains(avoid) + _touched(away, avoid)
            crossed = padded.count_contains(strange) + _touched(line, strange)
            cost = distance + COVERED_COST * covered + CROSSED_COST * crossed
            places.append(LabelPlace(cost, box, Path(line[[0, -1]] if wish.leader else line)))
    allowed = inf if wish.leader else COVERED_COST
    return sorted((p for p in places if p.cost < allowed), key=lambda place: place.cost)


def _around(wish: LabelRequest) -> Iterator[tuple[float, Bbox]]:
    (x, y), (width, height) = wish.anchor, wish.size
    for distance in DISTANCES if wish.leader else NEAR_DISTANCES:
        for angle in (2 * pi * direction / DIRECTIONS for direction in range(DIRECTIONS)):
            left = x + cos(angle) * (distance + width / 2) - width / 2
            bottom = y + sin(angle) * (distance + height / 2) - height / 2
            yield distance, Bbox.from_bounds(left, bottom, width, height)


def _touched(line: Points, points: Points) -> int:
    """Count the points of a line that are near to others."""
    low, high = line.min(axis=0, initial=inf), line.max(axis=0, initial=-inf)
    near = points[((low - COVER_MARGIN < points) & (points < high + COVER_MARGIN)).all(axis=1)]
    away = np.abs(line[:, np.newaxis] - near).max(axis=2)
    return int((away < COVER_MARGIN).any(axis=1).sum())
