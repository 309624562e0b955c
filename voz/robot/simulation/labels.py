"""The labels in the picture: commands and times along the way. Needs matplotlib."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import cos, hypot, pi, sin
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.transforms import Affine2D, Bbox

from voz.robot.simulation import shapes
from voz.robot.simulation.label_placement import LabelRequest, Points, hook, place_labels
from voz.robot.simulation.simulator import Trip, TripMark
from voz.robot.simulation.world import WorldState, joints_pointing_at, place_of

INTERVALS = ((1, 2), (1, 5), (2, 10), (5, 30), (10, 60), (60, 300), (300, 1800), (1800, 7200))
"""Seconds between time marks, and between numbered ones."""

MAX_NUMBERED_MARKS = 8

SAME_PLACE = 0.04
"""Commands said within this distance, m, one after the other, share a label."""

POINTING_TOLERANCE = 0.05
"""An arm points if its angles are this near to the wanted ones, rad."""


class TimeMark(NamedTuple):
    """Where the robot was after whole seconds; some marks have a number."""

    t: float
    x: float
    y: float
    text: str


def distance(states: Sequence[WorldState]) -> float:
    """Length of the way, m."""
    return sum(hypot(b.pose.x - a.pose.x, b.pose.y - a.pose.y) for a, b in pairwise(states))


def time_marks(states: Sequence[WorldState]) -> list[TimeMark]:
    """Return marks along the way, a few of them numbered; none while it stands still."""
    moving = [b.t for a, b in pairwise(states) if a.pose[:2] != b.pose[:2]]
    if not moving:
        return []
    span = moving[-1] - moving[0]
    fits = ((mark, number) for mark, number in INTERVALS if span / number <= MAX_NUMBERED_MARKS)
    every, numbered = next(fits, INTERVALS[-1])
    times = [state.t for state in states]
    marks = [TimeMark(0.0, *states[0].pose[:2], "")]
    for t in range(int(moving[0] / every) * every, int(moving[-1]) + 1, every):
        x, y, _ = states[max(0, bisect_right(times, t + 1e-6) - 1)].pose
        if hypot(x - marks[-1].x, y - marks[-1].y) > 0.01:
            marks.append(TimeMark(t, x, y, "" if t % numbered else f"{t} s"))
    return marks[1:]


def seconds_between(marks: Sequence[TimeMark]) -> float:
    """Return the time between marks, where the robot does not stand still between them."""
    return min((round(b.t - a.t, 3) for a, b in pairwise(marks)), default=0.0)


def same_place(said: Iterable[TripMark]) -> list[list[TripMark]]:
    """Group commands that were said one after the other in the same place."""
    groups: list[list[TripMark]] = []
    for mark in said:
        if groups and hypot(mark.x - groups[-1][0].x, mark.y - groups[-1][0].y) < SAME_PLACE:
            groups[-1].append(mark)
        else:
            groups.append([mark])
    return groups


def pointings(trip: Trip) -> list[WorldState]:
    """Return the last moment in which the arm pointed at each object."""
    states = trip.states
    last = {
        state.selected: state
        for state, following in zip(states, (*states[1:], None), strict=True)
        if (following is None or following.selected != state.selected) and _points(state, trip)
    }
    return list(last.values())


def _points(state: WorldState, trip: Trip) -> bool:
    target = place_of(state.selected, trip.settings)
    if target is None:
        return False
    wanted = joints_pointing_at(state.pose, target)
    return all(abs(a - b) < POINTING_TOLERANCE for a, b in zip(state.arm, wanted, strict=True))


MAX_LABEL_LINES = 10
"""Lines of a label; the last one counts the other commands of the place."""

MAX_LABELS = 60
"""Places that have labels at most, the last ones: more than there is room for."""

FIGURE_SPACE = "\u2007"
"""A space as wide as a digit, to align numbers."""

LABEL_PADDING, FRAME_PADDING = 1.0, 5.0
"""Space around a label without and with a frame, 1/72 inch."""


WALL_MARGIN = 4.0
"""From the middle of a wall to the nearest label, 1/72 inch."""

UNUSED_MARGIN = 20.0
"""Part of the right margin that stays empty, 1/72 inch."""

_SAID: Any = {"color": shapes.SAID, "zorder": 7, "clip_on": False}


class Label:
    """Lines of text beside the way, which appear one after the other."""

    def __init__(self, axes: Axes, lines: Sequence[TripMark], commands: int = 0) -> None:
        """Write the text, time and place of each line of a label.

        One with any commands has a frame, a dot and a leader.
        """
        self.place = lines[0].x, lines[0].y
        self._lines = lines
        self._axes = axes
        look: Any = {"fontsize": 8, "color": shapes.WAY}
        if commands:
            frame = {"boxstyle": "round,pad=0.25", "fc": "white", "ec": "#b8b8b8", "lw": 0.8}
            look = {"fontsize": 9, "bbox": frame, "linespacing": 1.25}
        text = "\n".join(line.text for line in lines)
        self._text = axes.text(*self.place, text, va="top", zorder=8, **look)
        self.commands = commands
        self.air = FRAME_PADDING if commands else LABEL_PADDING
        self.artists: list[Artist] = [self._text]

    def size(self, canvas: Any) -> tuple[float, float]:
        """Return its width and height with padding, 1/72 inch."""
        box = self._text.get_window_extent(canvas.get_renderer())
        point = canvas.figure.dpi / 72
        return box.width / point + 2 * self.air, box.height / point + 2 * self.air

    def put(self, corner: Points, hook: Points) -> None:
        """Move its upper left corner to a place, m, with a leader that ends at `hook`."""
        self._text.set_position((corner[0], corner[1]))
        if self.commands:
            (x, y), look = self.place, _SAID
            (leader,) = self._axes.plot([x, hook[0]], [y, hook[1]], lw=1, alpha=0.7, **look)
            (dot,) = self._axes.plot(x, y, "o", ms=7.5, mec="white", mew=1, **look)
            self.artists += [leader, dot]

    def remove(self) -> None:
        """Remove it: there is no room for it."""
        self._text.remove()
        self.artists = []

    def show(self, t: float) -> None:
        """Show the lines that are there at a time, s."""
        shown = [line.text for line in self._lines if line.t <= t]
        self._text.set_text("\n".join(shown))
        for artist in self.artists:
            artist.set_visible(bool(shown))


def write_along(
    axes: Axes, canvas: Any, trip: Trip, dots: Sequence[TimeMark], taken: Sequence[Artist]
) -> list[Label]:
    """Write commands and times beside the way, so that no text covers another or what is taken.

    Returns the labels; those without room are left out. The canvas measures the texts.
    """
    groups = [[TripMark(*dot)] for dot in dots if dot.text]
    labels = [Label(axes, group) for group in groups]
    said = same_place(trip.said)[-MAX_LABELS:]
    labels += [Label(axes, _lines(group), len(group)) for group in said]
    point = canvas.figure.dpi / 72
    on_paper = axes.transData + Affine2D().scale(1 / point)  # from m to 1/72 inch
    in_room = on_paper.inverted()
    (left, bottom), (right, top) = on_paper.transform([(0, 0), trip.settings.room])
    # Beside a narrow room there is space.
    right = max(right, canvas.figure.bbox.width / point - UNUSED_MARGIN)
    area = Bbox([[left, bottom], [right, top]]).padded(-WALL_MARGIN)
    boxes = [Bbox(artist.get_window_extent().get_points() / point) for artist in taken]
    wishes = [
        LabelRequest(tuple(on_paper.transform(label.place)), label.size(canvas), label.commands > 0)
        for label in labels
    ]
    places = place_labels(wishes, on_paper.transform(_busy(trip)), boxes, area)
    for label, box in zip(labels, places, strict=True):
        if box is None:
            label.remove()
        else:
            corner = (box.x0 + label.air, box.y1 - label.air)
            label.put(in_room.transform(corner), in_room.transform(hook(box)))
    return [label for label in labels if label.artists]


def _lines(group: Sequence[TripMark]) -> list[TripMark]:
    """List the commands of one place with their times; of too many, the first ones."""
    width = len(f"{group[-1].t:.1f}")
    lines = [
        mark._replace(text=f"{f'{mark.t:.1f}'.rjust(width, FIGURE_SPACE)} s  {mark.text}")
        for mark in group
    ]
    if len(lines) <= MAX_LABEL_LINES:
        return lines
    first = lines[: MAX_LABEL_LINES - 1]
    more = lines[MAX_LABEL_LINES - 1]
    return [*first, more._replace(text=f"and {len(lines) - len(first)} more")]


def _busy(trip: Trip) -> Points:
    """Return places in the room that labels should not cover, m."""
    settings, states = trip.settings, trip.states
    x, y, along, across = settings.table
    busy = [(x + along * i / 20, y + across * j / 20) for i in range(21) for j in range(21)]
    for share, pose in [(1.0, states[0].pose), *((s, states[-1].pose) for s in (0.3, 0.6, 1.0))]:
        radius, turns = settings.radius * share, [2 * pi * i / 32 for i in range(32)]
        busy += [(pose.x + radius * cos(turn), pose.y + radius * sin(turn)) for turn in turns]
    for state in pointings(trip):
        target = place_of(state.selected, settings) or (state.pose.x, state.pose.y, 0.0)
        busy += list(
            zip(
                np.linspace(state.pose.x, target[0], 60),
                np.linspace(state.pose.y, target[1], 60),
                strict=True,
            )
        )
    busy += [(settings.room[0], settings.room[1] * i / 50) for i in range(51)]
    busy += [state.pose[:2] for state in states[:: max(1, len(states) // 400)]]
    return np.array(busy)
