"""How a differential-drive base moves: its velocities lag behind, its way is made of arcs."""

from __future__ import annotations

from math import cos, expm1, pi, sin
from typing import NamedTuple

SETTLED = 0.001
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
    """Let a velocity follow the one asked for, as a first-order lag with a limit.

    Args:
        velocity: what it is, m/s or rad/s.
        wanted: what is asked for.
        time_constant: after which 63 % of a small difference is made up, s.
        acceleration: the most that it changes in a second.
        dt: how much time passes, s.

    Returns:
        What it is then.
    """
    difference, most = wanted - velocity, acceleration * dt
    if abs(difference) <= min(SETTLED, most):
        return wanted
    change = -expm1(-dt / time_constant) * difference
    return velocity + max(-most, min(change, most))


def along_arc(pose: Pose2D, distance: float, turn: float) -> Pose2D:
    """Drive along an arc, or along a line if it turns by 0, exactly.

    Args:
        pose: where it starts.
        distance: length of the arc, m; below 0 backward.
        turn: how far it turns to the left on it, rad.
    """
    # The chord of the arc, by which it is as exact for a tiny turn as for a large one.
    half = turn / 2
    chord = distance * (sin(half) / half if half else 1.0)
    direction = pose.heading + half
    return Pose2D(
        pose.x + chord * cos(direction),
        pose.y + chord * sin(direction),
        wrapped(pose.heading + turn) if turn else pose.heading,
    )


def wrapped(angle: float) -> float:
    """Give the same direction as an angle between -pi and pi, rad."""
    return (angle + pi) % (2 * pi) - pi
