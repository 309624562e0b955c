"""The robot in its room, whatever it is sent."""

from __future__ import annotations

from math import hypot, isfinite, pi

from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from voz.events import Twist
from voz.simulation.arm import FOLDED, joints_pointing_at
from voz.simulation.kinematics import Pose2D
from voz.simulation.simulator_settings import Simulator
from voz.simulation.world import CLEAR_DISTANCE, FOLD_ARM, WorldState, gap, place_of, start, step

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


def test_the_velocity_lags_behind_and_arrives() -> None:
    soon = drive(start(ROOM), 0.1, 0.0, 0.05, ROOM)
    assert 0 < soon.linear < 0.05
    assert drive(soon, 0.1, 0.0, 2.0, ROOM).linear == 0.1


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
