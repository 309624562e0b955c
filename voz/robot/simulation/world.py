"""The robot in its room: a pure function from a state, the velocity asked for and a time step."""

from __future__ import annotations

from math import atan2, copysign, cos, expm1, hypot, isfinite, pi, sin
from typing import NamedTuple, TypeAlias

import msgspec
from msgspec.structs import replace

from voz.events import Twist
from voz.settings import Simulator, Tabletop, gap_to_walls

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


OBJECT_IDS = {"beer": 1, "cocacola": 2}
"""Their numbers on `selected_object`."""

FOLD_ARM = 100
"""The number that folds the arm."""

TOUCH_DISTANCE = 0.0001
"""Nearer than this to a wall or the table, m, the base cannot move toward it."""

CLEAR_DISTANCE = 0.01
"""Farther than this from them, m, the next touch is another collision."""

ROUNDING_ERROR = 1e-9
"""Driving along a wall changes the distance to it by less than this, m."""

MAX_HALVINGS = 30
"""Halvings of a step to find where it touches: to a billionth."""


class WorldState(msgspec.Struct, frozen=True):
    """The robot at a time `t`, s: forward velocity in m/s, turning to the left in rad/s."""

    t: float
    pose: Pose2D
    linear: float = 0.0
    angular: float = 0.0
    arm: Joints = FOLDED
    selected: int = FOLD_ARM  # the object that the arm points at or is turning to; 100 folds it
    collided: bool = False  # whether the base touched something and is not away from it yet


class Gap(NamedTuple):
    """The free distance to the nearest obstacle, m, and which one that is."""

    size: float
    to: str


def start(settings: Simulator) -> WorldState:
    """Return the state at the start: the base at rest, the arm folded."""
    return WorldState(0.0, Pose2D(*settings.start))


def step(state: WorldState, twist: Twist, dt: float, settings: Simulator) -> WorldState:
    """Return the state after `dt` s; a `twist` that is too old stops the base."""
    state = _move_base(state, *_allowed_velocity(twist, state.t, settings), dt, settings)
    target = place_of(state.selected, settings)
    wanted = joints_pointing_at(state.pose, target) if target else FOLDED
    return replace(
        state, t=state.t + dt, arm=turn_joints(state.arm, wanted, settings.arm_speed * dt)
    )


def place_of(selected: int, settings: Simulator) -> Point | None:
    """Return where a selected object is; None for one that is not in the room, such as 100."""
    for name, place in (("beer", settings.beer), ("cocacola", settings.cocacola)):
        if selected == OBJECT_IDS[name]:
            return (*place, settings.table_height)
    return None


def gap(pose: Pose2D, settings: Simulator) -> Gap:
    """Return the distance from the base to a wall or the table, whichever is nearer."""
    to_walls = gap_to_walls(pose.x, pose.y, settings.radius, settings.room)
    to_table = Tabletop(*settings.table).gap(pose.x, pose.y, settings.radius)
    return min(Gap(to_walls, "a wall"), Gap(to_table, "the table"))


def _allowed_velocity(twist: Twist, now: float, settings: Simulator) -> tuple[float, float]:
    """Return the velocity that the base follows: within its limits, and 0 after the timeout."""
    too_old = now - twist.t >= settings.cmd_vel_timeout
    if too_old or not (isfinite(twist.linear) and isfinite(twist.angular)):
        return 0.0, 0.0
    fastest, tightest = settings.max_linear, settings.max_angular
    return (
        max(-fastest, min(twist.linear, fastest)),
        max(-tightest, min(twist.angular, tightest)),
    )


def _move_base(
    state: WorldState, linear: float, angular: float, dt: float, settings: Simulator
) -> WorldState:
    lag = settings.time_constant
    linear = respond(state.linear, linear, lag, settings.linear_acceleration, dt)
    angular = respond(state.angular, angular, lag, settings.angular_acceleration, dt)
    # The velocities change evenly within such a short time: their means give the arc.
    distance, turn = (state.linear + linear) / 2 * dt, (state.angular + angular) / 2 * dt
    pose = move_along_arc(state.pose, distance, turn)
    before, after = gap(state.pose, settings).size, gap(pose, settings).size
    if after < 0 or (after < TOUCH_DISTANCE and after < before - ROUNDING_ERROR):
        pose = _pose_at_touch(state.pose, distance, turn, settings)
        return replace(state, pose=pose, linear=0.0, angular=0.0, collided=True)
    collided = state.collided and after < CLEAR_DISTANCE
    return replace(state, pose=pose, linear=linear, angular=angular, collided=collided)


def _pose_at_touch(pose: Pose2D, distance: float, turn: float, settings: Simulator) -> Pose2D:
    """Return where along an arc the base first touches something."""
    free, blocked = 0.0, 1.0
    for _ in range(MAX_HALVINGS):
        middle = (free + blocked) / 2
        there = move_along_arc(pose, distance * middle, turn * middle)
        if gap(there, settings).size < TOUCH_DISTANCE / 2:
            blocked = middle
        else:
            free = middle
    return move_along_arc(pose, distance * free, turn * free)
