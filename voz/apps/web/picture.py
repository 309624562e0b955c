"""Where the robot is, for the picture: in the simulated room, or by its velocities alone."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Protocol

import msgspec

from voz.apps.web.board import Record
from voz.events import Event, SelectedObject, Twist
from voz.simulation.arm import points
from voz.simulation.kinematics import Pose2D, along_arc
from voz.simulation.simulator_settings import Simulator
from voz.simulation.world import WorldState

LONGEST_STEP = 0.5
"""A base stops by itself when no velocity came for so long, s."""


class Picture(Protocol):
    """What is drawn of the robot."""

    def about(self) -> Record:
        """What does not change."""

    def look(self) -> Record:
        """Where everything is now."""

    def receive(self, event: Event) -> None:
        """Learn from an event; it never waits."""


class RoomPicture:
    """The simulated robot in its room."""

    def __init__(self, settings: Simulator, state: Callable[[], WorldState]) -> None:
        """Take the room, and what tells how everything in it is."""
        self._settings = settings
        self._state = state

    def about(self) -> Record:
        """The room, its table and what stands on it, m."""
        room: Record = msgspec.to_builtins(self._settings)
        kept = ("room", "table", "beer", "cocacola", "radius", "start")
        return {name: room[name] for name in kept}

    def look(self) -> Record:
        """Where the robot and its arm are."""
        state = self._state()
        arm = [[round(x, 3), round(y, 3)] for x, y, _ in points(state.pose, state.arm)]
        moving = {"speed": round(state.linear, 3), "turning": round(state.angular, 3)}
        more = {"arm": arm, "selected": state.selected, "collided": state.collided}
        return {"pose": _rounded(state.pose), **moving, **more}

    def receive(self, event: Event) -> None:
        """The room learns from the events by itself."""


class ReckonedPicture:
    """Where a robot would be that does exactly what it is asked for: no sensor tells."""

    def __init__(self) -> None:
        self._pose = Pose2D(0.0, 0.0, 0.0)
        self._last = Twist(0.0, 0.0, 0.0)
        self._selected: deque[int] = deque(maxlen=1)

    def about(self) -> Record:
        """Nothing is known of the room."""
        return {}

    def look(self) -> Record:
        """Where the robot would be."""
        moving = {"speed": self._last.linear, "turning": self._last.angular}
        selected = {"selected": self._selected[0] if self._selected else None}
        return {"pose": _rounded(self._pose), **moving, **selected}

    def receive(self, event: Event) -> None:
        """Drive on to the time of an event by the velocity before it."""
        if isinstance(event, Twist):
            seconds = min(LONGEST_STEP, max(0.0, event.t - self._last.t))
            last = self._last
            self._pose = along_arc(self._pose, last.linear * seconds, last.angular * seconds)
            self._last = event
        elif isinstance(event, SelectedObject):
            self._selected.append(event.value)


def _rounded(pose: Pose2D) -> list[float]:
    return [round(pose.x, 3), round(pose.y, 3), round(pose.heading, 3)]
