"""An arm of two links on the robot's center: which angles point at a place, and where it then is.

The shoulder pans (rad, to the left of the robot's front) and tilts (rad, up from the horizontal);
the elbow bends the forearm further up (rad, 0 is straight).
"""

from __future__ import annotations

from math import atan2, copysign, cos, hypot, sin
from typing import NamedTuple, TypeAlias

from voz.simulation.kinematics import Pose2D, wrap_angle

SHOULDER_HEIGHT = 0.35
"""Of the shoulder above the floor, m."""

LINK_LENGTH = 0.22
"""Length of the upper arm and of the forearm, m: short enough to be folded above a small base."""

Point: TypeAlias = tuple[float, float, float]
"""x, y and height, m."""


class Joints(NamedTuple):
    """The three angles, rad."""

    pan: float
    tilt: float
    elbow: float


FOLDED = Joints(0.0, 2.3, -2.8)
"""The upper arm up and back, the forearm down to the front: all of it above the base."""


def joints_pointing_at(pose: Pose2D, target: Point) -> Joints:
    """Return the joints of an arm that is stretched toward a point of the room."""
    dx, dy, dz = target[0] - pose.x, target[1] - pose.y, target[2] - SHOULDER_HEIGHT
    return Joints(wrap_angle(atan2(dy, dx) - pose.heading), atan2(dz, hypot(dx, dy)), 0.0)


def turn_joints(joints: Joints, wanted: Joints, most: float) -> Joints:
    """Turn each joint toward its wanted angle by at most `most` rad; the pan the short way."""

    def turn(angle: float, wanted: float, by: float) -> float:
        return wanted if abs(by) <= most else angle + copysign(most, by)

    return Joints(
        wrap_angle(turn(joints.pan, wanted.pan, wrap_angle(wanted.pan - joints.pan))),
        turn(joints.tilt, wanted.tilt, wanted.tilt - joints.tilt),
        turn(joints.elbow, wanted.elbow, wanted.elbow - joints.elbow),
    )


def arm_points(pose: Pose2D, joints: Joints) -> tuple[Point, Point, Point]:
    """Return where shoulder, elbow and hand are in the room."""
    direction = pose.heading + joints.pan

    def link(start: Point, elevation: float) -> Point:
        flat = LINK_LENGTH * cos(elevation)
        return (
            start[0] + flat * cos(direction),
            start[1] + flat * sin(direction),
            start[2] + LINK_LENGTH * sin(elevation),
        )

    shoulder = (pose.x, pose.y, SHOULDER_HEIGHT)
    elbow = link(shoulder, joints.tilt)
    return shoulder, elbow, link(elbow, joints.tilt + joints.elbow)
