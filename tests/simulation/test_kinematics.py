from __future__ import annotations

from math import exp, hypot, isclose, pi

from hypothesis import given
from hypothesis import strategies as st

from voz.simulation.kinematics import (
    SETTLED_DIFFERENCE,
    Pose2D,
    move_along_arc,
    respond,
    wrap_angle,
)

velocities = st.floats(-2, 2)
poses = st.builds(Pose2D, st.floats(-5, 5), st.floats(-5, 5), st.floats(-pi, pi - 1e-6))


def apart(one: Pose2D, other: Pose2D) -> float:
    """Distance (m) and difference of heading (rad), whichever is more."""
    turn = wrap_angle(one.heading - other.heading)
    return max(hypot(one.x - other.x, one.y - other.y), abs(turn))


@given(poses, velocities, st.floats(-3, 3), st.floats(0.1, 3), st.integers(2, 300))
def test_an_arc_is_as_many_small_arcs(
    pose: Pose2D, linear: float, angular: float, seconds: float, parts: int
) -> None:
    at_once = move_along_arc(pose, linear * seconds, angular * seconds)
    for _ in range(parts):
        pose = move_along_arc(pose, linear * seconds / parts, angular * seconds / parts)
    assert apart(at_once, pose) < 1e-9


@given(poses, velocities, st.floats(-3, 3))
def test_an_arc_is_what_many_tiny_straight_steps_come_to(
    pose: Pose2D, linear: float, angular: float
) -> None:
    at_once, tiny = move_along_arc(pose, linear, angular), 1e-3
    for _ in range(1000):
        pose = move_along_arc(pose, linear * tiny, 0.0)
        pose = move_along_arc(pose, 0.0, angular * tiny)
    assert apart(at_once, pose) < abs(linear * angular) * tiny + 1e-9


@given(poses, velocities, st.floats(0.05, 3) | st.floats(-3, -0.05))
def test_a_full_circle_closes(pose: Pose2D, linear: float, angular: float) -> None:
    steps, end = 1000, pose
    for _ in range(steps):
        end = move_along_arc(end, linear * 2 * pi / abs(angular) / steps, 2 * pi / steps)
    assert apart(pose, end) < 1e-9


def test_half_a_circle_to_the_left_ends_on_the_left_and_looks_back() -> None:
    assert apart(move_along_arc(Pose2D(1.0, 1.0, 0.0), pi * 0.5, pi), Pose2D(1.0, 2.0, pi)) < 1e-12


@given(poses)
def test_no_velocity_is_no_motion_at_all(pose: Pose2D) -> None:
    assert move_along_arc(pose, 0.0, 0.0) == pose


@given(velocities, velocities, st.floats(0.01, 2), st.floats(0.01, 10), st.floats(0.001, 0.1))
def test_a_velocity_comes_nearer_within_its_acceleration(
    velocity: float, wanted: float, lag: float, acceleration: float, dt: float
) -> None:
    after = respond(velocity, wanted, lag, acceleration, dt)
    assert abs(after - velocity) <= acceleration * dt + 1e-12
    assert abs(after - wanted) <= abs(velocity - wanted)
    assert (after - wanted) * (velocity - wanted) >= 0  # never beyond


@given(velocities, velocities, st.floats(0.01, 1), st.floats(0.1, 10))
def test_a_velocity_arrives(
    velocity: float, wanted: float, lag: float, acceleration: float
) -> None:
    for _ in range(10_000):
        velocity = respond(velocity, wanted, lag, acceleration, 0.01)
    assert velocity == wanted


def test_a_small_change_follows_the_exponential_and_then_settles() -> None:
    assert isclose(respond(0.0, 0.1, 0.2, 10, 0.1), 0.1 * (1 - exp(-0.5)))
    assert respond(SETTLED_DIFFERENCE / 2, 0.0, 0.2, 10, 0.1) == 0.0
