"""The robot in its room, whatever it is sent."""

from __future__ import annotations

from math import dist, exp, hypot, isclose, isfinite, pi

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from voz.events import Twist
from voz.robot.simulation.world import (
    CLEAR_DISTANCE,
    FOLD_ARM,
    FOLDED,
    LINK_LENGTH,
    SETTLED_DIFFERENCE,
    SHOULDER_HEIGHT,
    Joints,
    Pose2D,
    WorldState,
    arm_points,
    gap,
    joints_pointing_at,
    move_along_arc,
    place_of,
    respond,
    start,
    step,
    turn_joints,
    wrap_angle,
)
from voz.settings import Simulator, Tabletop, gap_to_walls

ROOM = Simulator()
WIDE = Simulator(room=(50.0, 50.0), start=(25.0, 25.0, 0.0))
TIME_STEP = 0.01

anything = st.floats(-3, 3) | st.floats()
sent = st.lists(st.tuples(anything, anything, st.integers(1, 60)), max_size=12)


def drive(
    state: WorldState, linear: float, angular: float, seconds: float, room: Simulator
) -> WorldState:
    """Hold a velocity for a time that need not be a multiple of the step."""
    while seconds > 1e-9:
        dt = min(TIME_STEP, seconds)
        state = step(state, Twist(state.t, linear, angular), dt, room)
        seconds -= dt
    return state


@given(st.floats(0.05, 0.5), st.floats(0.1, 1.0), st.sampled_from((1, -1)))
@settings(max_examples=20)
def test_a_full_circle_closes_within_a_millimeter(linear: float, angular: float, side: int) -> None:
    begun = drive(start(WIDE), linear, side * angular, 3.0, WIDE)  # up to speed
    ended = drive(begun, linear, side * angular, 2 * pi / angular, WIDE)
    assert hypot(ended.pose.x - begun.pose.x, ended.pose.y - begun.pose.y) < 0.001


@given(sent, st.integers(0, 200), st.sampled_from((1, 2, FOLD_ARM)))
def test_walls_and_table_hold_and_no_limit_is_broken(
    sent: list[tuple[float, float, int]], silence: int, selected: int
) -> None:
    state = replace(start(ROOM), selected=selected)
    for linear, angular, steps in [*sent, (0.0, 0.0, silence)]:
        for _ in range(steps):
            before, state = state, step(state, Twist(state.t, linear, angular), TIME_STEP, ROOM)
            assert gap(state.pose, ROOM).size >= 0
            assert all(isfinite(value) for value in (*state.pose, *state.arm))
            assert abs(state.linear) <= ROOM.max_linear
            assert abs(state.angular) <= ROOM.max_angular
            if not state.collided:  # what hits a wall stops at once
                most, most_angular = ROOM.linear_acceleration, ROOM.angular_acceleration
                assert abs(state.linear - before.linear) <= most * TIME_STEP + 1e-12
                assert abs(state.angular - before.angular) <= most_angular * TIME_STEP + 1e-12


@given(st.floats(-0.5, 0.5), st.floats(-1, 1), st.floats(0, 3))
def test_a_robot_that_was_stopped_has_no_velocity_and_stays(
    linear: float, angular: float, seconds: float
) -> None:
    state = drive(start(ROOM), linear, angular, seconds, ROOM)
    state = drive(state, 0.0, 0.0, 3.0, ROOM)
    assert (state.linear, state.angular) == (0.0, 0.0)
    later = drive(state, 0.0, 0.0, 2.0, ROOM)
    assert later == replace(state, t=later.t)


def test_without_a_new_velocity_for_half_a_second_the_base_stops() -> None:
    state = drive(start(ROOM), 0.2, 0.3, 2.0, ROOM)
    last = Twist(state.t, 0.2, 0.3)
    for _ in range(49):
        state = step(state, last, TIME_STEP, ROOM)
    assert (state.linear, state.angular) == (0.2, 0.3)
    for _ in range(200):
        state = step(state, last, TIME_STEP, ROOM)
    assert (state.linear, state.angular) == (0.0, 0.0)


def test_a_velocity_that_is_no_number_stops_it() -> None:
    moving = drive(start(ROOM), 0.2, 0.0, 1.0, ROOM)
    for linear, angular in ((float("nan"), 0.0), (0.2, float("inf"))):
        assert drive(moving, linear, angular, 2.0, ROOM).linear == 0.0


def test_what_it_drives_into_stops_it_and_it_can_leave_again() -> None:
    hit = drive(start(ROOM), 0.5, 0.0, 10.0, ROOM)
    assert hit.collided
    assert (hit.linear, hit.angular) == (0.0, 0.0)
    assert gap(hit.pose, ROOM).size < 0.001
    assert gap(hit.pose, ROOM).to == "a wall"
    turned = drive(hit, 0.0, 0.5, 2.0, ROOM)  # on the spot
    assert turned.collided
    assert turned.pose.heading > 0.8
    away = drive(turned, -0.2, 0.0, 1.0, ROOM)
    assert not away.collided
    assert gap(away.pose, ROOM).size > CLEAR_DISTANCE


def test_a_base_that_pushes_stands_still() -> None:
    hit = drive(start(ROOM), 0.5, 0.0, 10.0, ROOM)
    for _ in range(100):
        pushing = step(hit, Twist(hit.t, 0.3, 0.2), TIME_STEP, ROOM)
        assert pushing == replace(hit, t=pushing.t)
        hit = pushing


def test_it_drives_along_a_wall_without_hitting_it() -> None:
    along = Simulator(start=(0.17, 0.5, pi / 2))
    state = drive(start(along), 0.3, 0.0, 2.0, along)
    assert not state.collided
    assert state.pose.y > 0.9


def test_the_table_is_in_the_way() -> None:
    state = replace(start(ROOM), pose=Pose2D(2.2, 1.0, pi / 2))
    hit = gap(drive(state, 0.5, 0.0, 5.0, ROOM).pose, ROOM)
    assert hit.to == "the table"
    assert 0 <= hit.size < 0.001


@given(st.floats(-0.3, 0.3), st.floats(-0.5, 0.5), st.sampled_from((1, 2)))
@settings(max_examples=30)
def test_the_arm_points_at_the_selected_object_while_the_robot_drives(
    linear: float, angular: float, selected: int
) -> None:
    state = drive(replace(start(ROOM), selected=selected), linear, angular, 4.0, ROOM)
    target = place_of(selected, ROOM)
    assert target is not None
    assert state.arm == joints_pointing_at(state.pose, target)


def test_100_folds_the_arm_and_so_does_what_is_not_there() -> None:
    pointed = drive(replace(start(ROOM), selected=1), 0.0, 0.0, 4.0, ROOM)
    assert pointed.arm != FOLDED
    for other in (FOLD_ARM, 7):
        folding = replace(pointed, selected=other)
        assert drive(folding, 0.0, 0.0, 0.1, ROOM).arm != FOLDED  # it takes its time
        assert drive(folding, 0.0, 0.0, 4.0, ROOM).arm == FOLDED


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


arm_poses = st.builds(Pose2D, st.floats(0, 5), st.floats(0, 5), st.floats(-pi, pi))
targets = st.tuples(st.floats(0, 5), st.floats(0, 5), st.floats(0, 2))
angles = st.floats(-pi, pi - 1e-6)
joints = st.builds(Joints, angles, angles, angles)


@given(arm_poses, targets)
def test_the_line_from_shoulder_to_hand_goes_through_the_target(
    pose: Pose2D, target: tuple[float, float, float]
) -> None:
    shoulder, elbow, hand = arm_points(pose, joints_pointing_at(pose, target))
    away = dist(shoulder, target)
    assume(away > 0.01)
    along = tuple(
        s + (h - s) * away / (2 * LINK_LENGTH) for s, h in zip(shoulder, hand, strict=True)
    )
    assert dist(along, target) < 1e-9
    assert dist(elbow, [(s + h) / 2 for s, h in zip(shoulder, hand, strict=True)]) < 1e-9


@given(arm_poses, joints)
def test_the_links_keep_their_length_and_the_shoulder_its_place(pose: Pose2D, arm: Joints) -> None:
    shoulder, elbow, hand = arm_points(pose, arm)
    assert shoulder == (pose.x, pose.y, SHOULDER_HEIGHT)
    assert dist(shoulder, elbow) == pytest.approx(LINK_LENGTH)
    assert dist(elbow, hand) == pytest.approx(LINK_LENGTH)


def test_what_is_to_the_left_and_above_needs_a_pan_to_the_left_and_a_tilt_up() -> None:
    arm = joints_pointing_at(Pose2D(1.0, 1.0, 0.0), (1.0, 2.0, SHOULDER_HEIGHT + 1.0))
    assert arm == pytest.approx((pi / 2, pi / 4, 0.0))
    assert joints_pointing_at(
        Pose2D(1.0, 1.0, pi / 2), (1.0, 2.0, SHOULDER_HEIGHT)
    ).pan == pytest.approx(0)


@given(arm_poses)
def test_a_folded_arm_is_above_its_base(pose: Pose2D) -> None:
    for x, y, height in arm_points(pose, FOLDED):
        assert hypot(x - pose.x, y - pose.y) < 0.17
        assert height >= SHOULDER_HEIGHT


@given(joints, joints, st.floats(0.001, 1))
def test_no_joint_turns_faster_than_its_limit(arm: Joints, wanted: Joints, most: float) -> None:
    after = turn_joints(arm, wanted, most)
    angles = [wrap_angle(after.pan - arm.pan), after.tilt - arm.tilt, after.elbow - arm.elbow]
    assert all(abs(angle) <= most + 1e-12 for angle in angles)


@given(joints, joints)
def test_an_arm_arrives_and_stays(arm: Joints, wanted: Joints) -> None:
    for _ in range(80):
        arm = turn_joints(arm, wanted, 0.1)
    assert arm == pytest.approx(wanted)
    assert turn_joints(arm, wanted, 0.1) == arm


def test_the_pan_goes_the_short_way_round() -> None:
    after = turn_joints(Joints(3.0, 0.0, 0.0), Joints(-3.0, 0.0, 0.0), 0.1)
    assert after.pan == pytest.approx(3.1)


TABLE = Tabletop(1.0, 2.0, 0.5, 1.5)
floor_places = st.tuples(st.floats(0, 4), st.floats(0, 4))


def test_the_nearest_wall_counts() -> None:
    room = (4.0, 3.0)
    gaps = [gap_to_walls(x, y, 0.2, room) for x, y in [(1, 1.5), (3.5, 1.5), (2, 2.9), (2, 0.1)]]
    assert gaps == pytest.approx([0.8, 0.3, -0.1, -0.1])


def test_the_nearest_edge_or_corner_of_the_table_counts() -> None:
    gaps = [TABLE.gap(x, y, 0.1) for x, y in [(0.5, 3), (2, 3), (1.2, 1), (0.7, 1.6)]]
    assert gaps == pytest.approx([0.4, 0.4, 0.9, 0.4])
    assert TABLE.gap(1.2, 2.5, 0.1) == pytest.approx(-0.1)


@given(floor_places, st.floats(0, 1), st.floats(0, 1))
def test_no_point_of_the_table_is_nearer_than_the_gap(
    place: tuple[float, float], along: float, across: float
) -> None:
    corner = (TABLE.x + TABLE.width * along, TABLE.y + TABLE.depth * across)
    away = hypot(corner[0] - place[0], corner[1] - place[1])
    assert away >= TABLE.gap(*place, 0.0) - 1e-12
    assert TABLE.holds(*place) == (TABLE.gap(*place, 0.0) == 0)
