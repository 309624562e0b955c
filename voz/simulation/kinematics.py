"""How a differential-drive base moves: along arcs, with velocities that lag behind."""

from __future__ import annotations

from math import cos, expm1, pi, sin
from typing import NamedTuple

SETTLED_DIFFERENCE = 0.001
"""A velocity this near (m/s, rad/s) to the one asked for takes it: an exponential never arrives."""


class Pose2D(NamedTuple):
    """Where the robot's center is (m) and where it looks (rad, to the left of the x axis)."""

    x: float
    y: float
    heading: float

    def quaternion(self) -> tuple[float, float]:
        """The heading as the z and w of a quaternion; x and y are 0."""
        return sin(self.heading / 2), cos(self.heading / 2)


def respond(
    velocity: float, wanted: float, time_constant: float, acceleration: float, dt: float
) -> float:
    """Return a velocity (m/s or rad/s) that follows `wanted` for `dt` s.

    It is a first-order lag with a time constant (s) and a maximum acceleration.
    """
    difference, most = wanted - velocity, acceleration * dt
    if abs(difference) <= min(SETTLED_DIFFERENCE, most):
        return wanted
    change = -expm1(-dt / time_constant) * difference
    return velocity + max(-most, min(change, most))


def move_along_arc(pose: Pose2D, distance: float, turn: float) -> Pose2D:
    """Move a pose along an arc of a length (m, below 0 backward) that turns left by `turn`, rad."""
    # By the chord of the arc, which is exact for tiny turns, too.
    half = turn / 2
    chord = distance * (sin(half) / half if half else 1.0)
    direction = pose.heading + half
    return Pose2D(
        pose.x + chord * cos(direction),
        pose.y + chord * sin(direction),
        wrap_angle(pose.heading + turn) if turn else pose.heading,
    )


def wrap_angle(angle: float) -> float:
    """Return the same angle between -pi and pi, rad."""
    return (angle + pi) % (2 * pi) - pi
