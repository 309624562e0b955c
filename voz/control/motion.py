"""How a command changes the velocities, and where a motion ends by itself. Pure."""

from __future__ import annotations

import enum
import math
from typing import Any, TypeAlias

import msgspec
from msgspec.structs import replace

from voz.control.steps import PER_UNIT, Step


class Mode(enum.Enum):
    """Whether the last change of direction was a turn in motion or a rotation on the spot."""

    NONE = "none"
    TURNING = "turning"
    ROTATING = "rotating"


class Motion(msgspec.Struct, frozen=True):
    """Velocities: forward, thousandths of 1 m/s, and to the left, thousandths of 1 rad/s."""

    linear: int = 0
    angular: int = 0
    mode: Mode = Mode.NONE

    @property
    def moving(self) -> bool:
        """Whether any velocity is not 0."""
        return bool(self.linear or self.angular)

    def velocities(self) -> tuple[float, float]:
        """The linear (m/s) and angular (rad/s) velocity."""
        return self.linear / PER_UNIT, self.angular / PER_UNIT


def halt(motion: Motion) -> Motion:
    """Both velocities 0; the mode stays."""
    return replace(motion, linear=0, angular=0)


def go(motion: Motion, linear: int) -> Motion:
    """Drive straight at a new linear velocity."""
    return replace(motion, linear=linear, angular=0)


def turn(motion: Motion, angular: int) -> Motion:
    """Turn to the side of `angular` while driving; a turn to that side gets tighter."""
    if motion.angular * angular <= 0 or motion.mode is Mode.ROTATING:
        return replace(motion, angular=angular, mode=Mode.TURNING)
    return replace(motion, angular=motion.angular + angular)


def rotate(motion: Motion, angular: int) -> Motion:
    """Rotate on the spot to the side of `angular`."""
    if motion.angular * angular <= 0 or motion.mode is Mode.TURNING:
        return replace(motion, linear=0, angular=angular, mode=Mode.ROTATING)
    return replace(motion, linear=0)


def faster(motion: Motion, by: int) -> Motion:
    """Move the velocity in use away from 0."""
    if motion.linear:
        return replace(motion, linear=motion.linear + (by if motion.linear > 0 else -by))
    if motion.mode is Mode.ROTATING:
        return replace(motion, angular=motion.angular + (by if motion.angular > 0 else -by))
    return motion


def slower(motion: Motion, by: int) -> Motion:
    """Move the velocity in use toward 0, and past 0 to the other side."""
    return faster(motion, -by)


def apply_step(motion: Motion, step: Step) -> Motion:
    """Apply the velocities of a step whose slots are filled."""
    if step.stop:
        return halt(motion)
    if step.bounded:  # its velocity does not depend on the one before
        motion = replace(motion, angular=0)
    for name, change in CHANGES.items():
        amount = getattr(step, name)
        if amount is not None:
            return change(motion, round(amount * PER_UNIT))
    return motion


CHANGES = {"drive": go, "turn": turn, "rotate": rotate, "faster": faster, "slower": slower}


Place: TypeAlias = tuple[float, float, float]
"""Where odometry has a robot: x and y, m, and its heading, rad."""

MAX_DELAY_FACTOR = 1.5
"""With odometry, a motion may take this many times longer than its velocity promises.

A base accelerates slowly and slips; odometry that stands still must not let it drive forever.
"""

MAX_ODOMETRY_AGE = 0.5
"""Older odometry is not used, s."""

HALF_BEAT = 0.05
"""A motion ends with the beat that is nearest to its end, s."""


def place_from_odometry(odometry: tuple[float, Any] | None, now: float) -> Place | None:
    """Return where the newest odometry has a robot; None if there is none or it is too old.

    `odometry` is when it came, s, and a `nav_msgs/Odometry` of ROS 1 or ROS 2.
    """
    if odometry is None or now - odometry[0] >= MAX_ODOMETRY_AGE:
        return None
    pose = odometry[1].pose.pose
    heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
    return pose.position.x, pose.position.y, math.remainder(heading, math.tau)


class BoundedMotion(msgspec.Struct, frozen=True):
    """A motion under way, and where it ends."""

    t: float  # the time of the last update, s
    until: float | None = None  # when it ends, s; None if only distance or angle end it
    # The distance at which it ends; None if it turns or only time ends it.
    metres: float | None = None
    radians: float | None = None  # the angle at which it ends
    expected: float = 0.0  # how far it came by its velocity and the time, m or rad
    origin: Place | None = None  # where odometry had the robot first; None without odometry
    heading: float = 0.0  # the last heading of odometry, rad
    angle: float = 0.0  # how far it turned by odometry, rad
    distance: float = 0.0  # how far it came by odometry, m


def begin_bounded(step: Step, t: float, place: Place | None) -> BoundedMotion:
    """Begin the motion of a step without slots; `place` is that of the robot by odometry."""
    seconds, metres, degrees = (_number(x) for x in (step.seconds, step.metres, step.degrees))
    return BoundedMotion(
        t,
        None if seconds is None else t + seconds,
        metres,
        None if degrees is None else math.radians(degrees),
        origin=place,
        heading=place[2] if place else 0.0,
    )


def update_bounded(
    bounded: BoundedMotion, motion: Motion, t: float, place: Place | None
) -> BoundedMotion:
    """Add what the robot has moved since the last update, at the velocities of `motion`."""
    expected = bounded.expected + _speed(bounded, motion) * (t - bounded.t)
    if place is None or bounded.origin is None:
        return replace(bounded, t=t, expected=expected, origin=None)
    return replace(
        bounded,
        t=t,
        expected=expected,
        heading=place[2],
        angle=bounded.angle + math.remainder(place[2] - bounded.heading, math.tau),
        distance=math.dist(place[:2], bounded.origin[:2]),
    )


def is_finished(bounded: BoundedMotion, motion: Motion) -> bool:
    """Whether the motion is at its end."""
    if bounded.until is not None and bounded.t + HALF_BEAT > bounded.until:
        return True
    goal = bounded.metres if bounded.radians is None else bounded.radians
    if goal is None:
        return False
    measured = bounded.distance if bounded.radians is None else abs(bounded.angle)
    limit = goal if bounded.origin is None else goal * MAX_DELAY_FACTOR
    near = HALF_BEAT * _speed(bounded, motion)
    return bounded.expected + near > limit or (
        bounded.origin is not None and measured + near > goal
    )


def _speed(bounded: BoundedMotion, motion: Motion) -> float:
    linear, angular = motion.velocities()
    return abs(linear) if bounded.radians is None else abs(angular)


def _number(amount: float | str | None) -> float | None:
    return None if amount is None else float(amount)
