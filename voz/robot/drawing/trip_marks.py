"""The marks in the picture of a trip: times, commands, pointing. Pure."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import hypot
from typing import NamedTuple

from voz.robot.simulator import Trip, TripMark
from voz.simulation.arm import joints_pointing_at
from voz.simulation.world import WorldState, place_of

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
