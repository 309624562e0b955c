"""The robot in its room: a pure function from a state, the velocity asked for and a time step.

It reads no clock: time is what the events say, so the same events give the same way.
"""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

import msgspec
from msgspec.structs import replace

from voz.events import Twist
from voz.simulation.arm import FOLDED, Joints, Point, pointing, turned
from voz.simulation.kinematics import Pose2D, along_arc, respond
from voz.simulation.room import Tabletop, gap_to_table, gap_to_walls
from voz.simulation.simulator_settings import Simulator

OBJECTS = {"beer": 1, "cocacola": 2}
"""What `selected_object` has for the things on the table."""

FOLD = 100
"""The selected object that means none."""

TOUCH = 0.0001
"""Nearer than this to a wall or the table, m, the base does not drive towards it."""

AWAY = 0.01
"""Farther than this from them, m, the next touch is another collision."""

ROUNDING = 1e-9
"""Driving along a wall changes the distance to it by less than this, m."""

HALVINGS = 30
"""How often a step is halved to find where it touches: a billionth of it remains."""


class WorldState(msgspec.Struct, frozen=True):
    """All of the robot at a moment.

    Attributes:
        t: when it is, s.
        pose: where the base is.
        linear: its velocity forward, m/s.
        angular: its velocity of turning to the left, rad/s.
        arm: the angles of its joints.
        selected: the object that the arm points at or is turning to; 100 folds it.
        collided: whether it has touched something and is not away from it yet.
    """

    t: float
    pose: Pose2D
    linear: float = 0.0
    angular: float = 0.0
    arm: Joints = FOLDED
    selected: int = FOLD
    collided: bool = False


class Gap(NamedTuple):
    """The free way to what is nearest, m, and what that is."""

    size: float
    to: str


def start(settings: Simulator) -> WorldState:
    """Where everything begins: the base at rest, the arm folded."""
    return WorldState(0.0, Pose2D(*settings.start))


def step(state: WorldState, twist: Twist, dt: float, settings: Simulator) -> WorldState:
    """Let time pass.

    Args:
        state: how everything is now.
        twist: the last velocity that came; when it is too old, the base stops.
        dt: how much time passes, s; small against the sizes of the room over the velocity.
        settings: the room and the limits.

    Returns:
        How everything is then.
    """
    state = _driven(state, *_obeyed(twist, state.t, settings), dt, settings)
    target = place_of(state.selected, settings)
    wanted = pointing(state.pose, target) if target else FOLDED
    return replace(state, t=state.t + dt, arm=turned(state.arm, wanted, settings.arm_speed * dt))


def place_of(selected: int, settings: Simulator) -> Point | None:
    """Where a selected object is; None for one that is not in the room, as 100."""
    for name, place in (("beer", settings.beer), ("cocacola", settings.cocacola)):
        if selected == OBJECTS[name]:
            return (*place, settings.table_height)
    return None


def gap(pose: Pose2D, settings: Simulator) -> Gap:
    """How far the base is from a wall or the table, whichever is nearer."""
    to_walls = gap_to_walls(pose.x, pose.y, settings.radius, settings.room)
    to_table = gap_to_table(pose.x, pose.y, settings.radius, Tabletop(*settings.table))
    return min(Gap(to_walls, "a wall"), Gap(to_table, "the table"))


def _obeyed(twist: Twist, now: float, settings: Simulator) -> tuple[float, float]:
    """The velocity that the base follows: within its limits, and 0 when nothing came for long."""
    too_old = now - twist.t >= settings.cmd_vel_timeout
    if too_old or not (isfinite(twist.linear) and isfinite(twist.angular)):
        return 0.0, 0.0
    fastest, tightest = settings.max_linear, settings.max_angular
    return (
        max(-fastest, min(twist.linear, fastest)),
        max(-tightest, min(twist.angular, tightest)),
    )


def _driven(
    state: WorldState, linear: float, angular: float, dt: float, settings: Simulator
) -> WorldState:
    """Move the base, up to what it would hit; that stops it."""
    lag = settings.time_constant
    linear = respond(state.linear, linear, lag, settings.linear_acceleration, dt)
    angular = respond(state.angular, angular, lag, settings.angular_acceleration, dt)
    # The velocities change evenly within so short a time: their means give the arc.
    distance, turn = (state.linear + linear) / 2 * dt, (state.angular + angular) / 2 * dt
    pose = along_arc(state.pose, distance, turn)
    before, after = gap(state.pose, settings).size, gap(pose, settings).size
    if after < 0 or (after < TOUCH and after < before - ROUNDING):
        pose = _up_to_touch(state.pose, distance, turn, settings)
        return replace(state, pose=pose, linear=0.0, angular=0.0, collided=True)
    collided = state.collided and after < AWAY
    return replace(state, pose=pose, linear=linear, angular=angular, collided=collided)


def _up_to_touch(pose: Pose2D, distance: float, turn: float, settings: Simulator) -> Pose2D:
    """Where along an arc the base first touches something; it begins where it is free."""
    free, blocked = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = (free + blocked) / 2
        there = along_arc(pose, distance * middle, turn * middle)
        if gap(there, settings).size < TOUCH / 2:
            blocked = middle
        else:
            free = middle
    return along_arc(pose, distance * free, turn * free)
