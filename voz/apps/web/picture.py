"""Where the robot is shown: in the simulated room, or by its velocities alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import msgspec

from voz.apps.web.page_messages import Record
from voz.events import Event, SelectedObject, Twist
from voz.robot.simulation.world import Pose2D, WorldState, arm_points, move_along_arc
from voz.settings import Simulator

MAX_STEP = 0.5
"""A base stops by itself when no velocity came for so long, s."""


class Picture(Protocol):
    """What is drawn of the robot."""

    def room(self) -> Record:
        """The room, m; empty if it is not known."""

    def state(self) -> Record:
        """Where everything is now."""

    def receive(self, event: Event) -> None:
        """Take an event; it never waits."""


class RoomPicture:
    """The simulated robot in its room."""

    def __init__(self, settings: Simulator, world_state: Callable[[], WorldState]) -> None:
        self._settings = settings
        self._world_state = world_state

    def room(self) -> Record:
        """The room, its table and what stands on it, m."""
        room: Record = msgspec.to_builtins(self._settings)
        shown = ("room", "table", "beer", "cocacola", "radius", "start")
        return {name: room[name] for name in shown}

    def state(self) -> Record:
        """Where the robot and its arm are."""
        world = self._world_state()
        arm = [[round(x, 3), round(y, 3)] for x, y, _ in arm_points(world.pose, world.arm)]
        moving = {"speed": round(world.linear, 3), "turning": round(world.angular, 3)}
        more = {"arm": arm, "selected": world.selected, "collided": world.collided}
        return {"pose": _rounded(world.pose), **moving, **more}

    def receive(self, event: Event) -> None:
        """Do nothing: the simulator itself gets the events."""


class DeadReckoningPicture:
    """Where a robot would be that does exactly what it is told: no sensor says where it is."""

    def __init__(self) -> None:
        self._pose = Pose2D(0.0, 0.0, 0.0)
        self._last = Twist(0.0, 0.0, 0.0)
        self._selected: int | None = None

    def room(self) -> Record:
        """Nothing is known of the room."""
        return {}

    def state(self) -> Record:
        """Where the robot would be."""
        moving = {"speed": self._last.linear, "turning": self._last.angular}
        return {"pose": _rounded(self._pose), **moving, "selected": self._selected}

    def receive(self, event: Event) -> None:
        """Drive on to the time of an event by the velocity before it."""
        if isinstance(event, Twist):
            seconds = min(MAX_STEP, max(0.0, event.t - self._last.t))
            last = self._last
            self._pose = move_along_arc(self._pose, last.linear * seconds, last.angular * seconds)
            self._last = event
        elif isinstance(event, SelectedObject):
            self._selected = event.value


def _rounded(pose: Pose2D) -> list[float]:
    return [round(pose.x, 3), round(pose.y, 3), round(pose.heading, 3)]
