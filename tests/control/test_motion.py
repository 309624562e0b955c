"""What each change does to the velocities, at its smallest too."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace

import pytest
from hypothesis import given, reject
from hypothesis import strategies as st
from msgspec.structs import replace

from voz.config import Config
from voz.control.motion import (
    BoundedMotion,
    Mode,
    Motion,
    Place,
    apply_step,
    begin_bounded,
    faster,
    is_finished,
    place_from_odometry,
    rotate,
    slower,
    turn,
    update_bounded,
)
from voz.control.state_machine import GivenCommand, State, let_time_pass, obey
from voz.control.steps import CommandDefinition, Step
from voz.errors import ConfigError
from voz.settings import Safety

TURNING, ROTATING = Mode.TURNING, Mode.ROTATING


@pytest.mark.parametrize(
    ("before", "angular", "after"),
    [
        (Motion(5, 1, TURNING), 1, Motion(5, 2, TURNING)),
        (Motion(5, -1, TURNING), -1, Motion(5, -2, TURNING)),
        (Motion(5, 1, TURNING), -1, Motion(5, -1, TURNING)),
        (Motion(0, 1, ROTATING), 1, Motion(0, 1, TURNING)),
        (Motion(5, 1, TURNING), 0, Motion(5, 0, TURNING)),
    ],
)
def test_a_turn_to_the_same_side_gets_tighter(before: Motion, angular: int, after: Motion) -> None:
    assert turn(before, angular) == after


@pytest.mark.parametrize(
    ("before", "angular", "after"),
    [
        (Motion(5, 1), 1, Motion(0, 1)),
        (Motion(5, 1, TURNING), 2, Motion(0, 2, ROTATING)),
        (Motion(0, 1, ROTATING), -1, Motion(0, -1, ROTATING)),
        (Motion(0, 1, ROTATING), 2, Motion(0, 1, ROTATING)),
        (Motion(0, 1, ROTATING), 0, Motion(0, 0, ROTATING)),
    ],
)
def test_a_rotation_to_the_same_side_goes_on(before: Motion, angular: int, after: Motion) -> None:
    assert rotate(before, angular) == after


@pytest.mark.parametrize("sign", [1, -1])
def test_the_least_velocity_has_a_side_too(sign: int) -> None:
    assert faster(Motion(sign), 50) == Motion(51 * sign)
    assert slower(Motion(sign), 50) == Motion(-49 * sign)
    assert faster(Motion(0, sign, ROTATING), 50) == Motion(0, 51 * sign, ROTATING)


def test_a_step_without_a_velocity_changes_none() -> None:
    assert apply_step(Motion(5, 1, TURNING), Step(say="well")) == Motion(5, 1, TURNING)


SAFE = Safety()
NOWHERE: Callable[[float], Place | None] = lambda _: None  # noqa: E731
TABLE = Config(
    commands={
        "one metre": Step(drive=0.25, metres=1),
        "half a turn": Step(rotate=-0.5, degrees=180),
        "a while": Step(turn=0.1, seconds=2),
        "square": (Step(drive=0.1, metres=0.2), Step(rotate=0.5, degrees=90), Step(say="there")),
        "again": Step(again=True),
        "again, please": (Step(again=True), Step(say="once more")),
        "on": (Step(say="on and on"), Step(drive=0.1)),
    }
).table


def say(state: State, name: str, t: float = 0.0, place: Place | None = None) -> State:
    return obey(state, GivenCommand(name, {}, t), TABLE, SAFE, place).state


def until_rest(
    state: State, where: Callable[[float], Place | None] = NOWHERE, begin: float = 0.0
) -> tuple[float, list[object]]:
    """Let the beat go on until nothing moves; gives when that is, and what went out."""
    events: list[object] = []
    for beat in range(1, 2000):
        t = begin + beat / 10
        state, more, *_ = let_time_pass(state, t, SAFE, where(t))
        events += more
        if not state.moving:
            return t, events
    raise AssertionError("it goes on and on")


LISTENING = State(listening=True)


def test_odometry_tells_the_place_while_it_is_new() -> None:
    half = math.sqrt(0.5)
    pose = SimpleNamespace(
        position=SimpleNamespace(x=1.0, y=-2.0), orientation=SimpleNamespace(z=-half, w=-half)
    )
    odometry = 3.0, SimpleNamespace(pose=SimpleNamespace(pose=pose))
    place = place_from_odometry(odometry, 3.0)
    assert place == pytest.approx((1.0, -2.0, math.pi / 2))
    assert place_from_odometry(odometry, 3.49) == place
    assert place_from_odometry(odometry, 3.5) is None
    assert place_from_odometry(None, 3.0) is None


def test_what_it_has_moved_is_known_by_its_velocity_and_by_odometry() -> None:
    way = begin_bounded(Step(drive=0.5, metres=2, seconds=9), 1.0, None)
    assert way == BoundedMotion(1.0, 10.0, 2.0, None, 0.0, None, 0.0, 0.0, 0.0)
    assert update_bounded(way, Motion(linear=-500), 3.0, (1.0, 2.0, 0.5)) == replace(
        way, t=3.0, expected=1.0
    )
    turn = begin_bounded(Step(rotate=0.5, degrees=180), 1.0, (1.0, 2.0, 3.0))
    assert turn == BoundedMotion(1.0, None, None, math.pi, 0.0, (1.0, 2.0, 3.0), 3.0, 0.0, 0.0)
    for _ in range(2):  # a circle, a quarter at a time
        turn = update_bounded(turn, Motion(angular=500), turn.t + 3, (4.0, 6.0, turn.heading - 1.5))
    assert (turn.t, turn.expected, turn.heading, turn.angle) == (7.0, 3.0, 0.0, -3.0)
    assert turn.distance == 5.0
    begun = BoundedMotion(0.0, radians=1.0, origin=HERE)
    assert update_bounded(begun, STILL, 0.1, (0.0, 0.0, 0.5)).angle == 0.5


HERE: Place = (0.0, 0.0, 0.0)
SLOW, STILL = Motion(linear=500, angular=-500), Motion()


@pytest.mark.parametrize(
    ("bounded", "motion", "finished"),
    [
        (BoundedMotion(0.0, until=0.05), STILL, False),  # the next beat is as near
        (BoundedMotion(0.001, until=0.05), STILL, True),
        (BoundedMotion(1.94, until=2.0), STILL, False),
        (BoundedMotion(9.0, metres=1.0, expected=1.0), STILL, False),
        (BoundedMotion(9.0, metres=1.0, expected=1.01), STILL, True),
        (BoundedMotion(9.0, metres=1.0, expected=0.97), SLOW, False),
        (BoundedMotion(9.0, metres=1.0, expected=0.98), SLOW, True),
        (BoundedMotion(9.0, radians=1.0, expected=0.98), SLOW, True),
        (BoundedMotion(9.0, metres=1.0, expected=1.5, origin=HERE), STILL, False),
        (BoundedMotion(9.0, metres=1.0, expected=1.51, origin=HERE), STILL, True),
        (BoundedMotion(9.0, metres=1.0, distance=1.0, origin=HERE), STILL, False),
        (BoundedMotion(9.0, metres=1.0, distance=1.01, origin=HERE), STILL, True),
        (BoundedMotion(9.0, metres=1.0, distance=0.97, origin=HERE), SLOW, False),
        (BoundedMotion(9.0, metres=1.0, distance=0.98, origin=HERE), SLOW, True),
        (BoundedMotion(9.0, metres=1.0, distance=2.0), SLOW, False),
        (BoundedMotion(9.0, radians=1.0, angle=-1.01, origin=HERE), STILL, True),
        (BoundedMotion(9.0, until=99.0, expected=9.0), SLOW, False),
    ],
)
def test_it_ends_with_the_beat_that_is_nearest_to_its_end(
    bounded: BoundedMotion, motion: Motion, finished: bool
) -> None:
    assert is_finished(bounded, motion) == finished


@pytest.mark.parametrize(
    ("name", "seconds"),
    [("one metre", 4.0), ("half a turn", 2 * math.pi), ("a while", 2.0)],
)
def test_without_odometry_it_ends_by_time(name: str, seconds: float) -> None:
    t, _ = until_rest(say(LISTENING, name))
    assert t == pytest.approx(seconds, abs=0.06)


def test_odometry_ends_it_where_it_is() -> None:
    slow = lambda t: (0.2 * t, 0.0, 0.0)  # noqa: E731 (a base that slips a fifth of its way)
    t, _ = until_rest(say(LISTENING, "one metre", place=slow(0)), slow)
    assert t == pytest.approx(5.0, abs=0.11)
    round_the_back = lambda t: (0.0, 0.0, math.remainder(3 - 0.5 * t, math.tau))  # noqa: E731
    t, _ = until_rest(say(LISTENING, "half a turn", place=round_the_back(0)), round_the_back)
    assert t == pytest.approx(2 * math.pi, abs=0.11)


def test_odometry_that_stands_still_drives_it_not_for_ever() -> None:
    here: Place = (1.0, 2.0, 0.5)
    t, _ = until_rest(say(LISTENING, "one metre", place=here), lambda _: here)
    assert t == pytest.approx(6.0, abs=0.11)


def test_odometry_that_is_lost_on_the_way_leaves_the_time() -> None:
    lost = lambda t: (0.25 * t, 0.0, 0.0) if t < 2 else None  # noqa: E731
    t, _ = until_rest(say(LISTENING, "one metre", place=lost(0)), lost)
    assert t == pytest.approx(4.0, abs=0.11)


def test_steps_follow_each_other() -> None:
    state = say(LISTENING, "square")
    assert state.motion.velocities() == (0.1, 0)
    t, events = until_rest(state)
    assert t == pytest.approx(2.0 + math.pi, abs=0.2)
    assert [getattr(event, "text", None) for event in events] == ["there"]


@pytest.mark.parametrize("name", ["stop", "stop speech"])
def test_what_stops_leaves_nothing_to_do(name: str) -> None:
    state = say(say(LISTENING, "square"), name, 1.0)
    assert not state.moving
    assert let_time_pass(state, 60.0, SAFE).state == state


def test_by_the_bare_rules_too_a_bounded_motion_ends_though_nobody_listens_any_more() -> None:
    bare = Safety(enabled=False)
    state = obey(
        say(LISTENING, "one metre"), GivenCommand("stop speech", {}, 1.0), TABLE, bare
    ).state
    assert state.moving
    t, _ = until_rest(state, begin=0.0)
    assert t == pytest.approx(4.0, abs=0.06)


def test_another_motion_takes_its_place_and_does_not_inherit_it() -> None:
    state = say(say(LISTENING, "one metre"), "turn left", 1.0)
    assert state.motion.velocities() == (0, 0.1)
    assert state.bounded is None


def test_speed_up_keeps_the_end() -> None:
    state = let_time_pass(say(LISTENING, "one metre"), 2.0, SAFE).state
    state = say(state, "speed up", 2.0)
    assert state.motion.velocities() == (0.3, 0)
    t, _ = until_rest(state, begin=2.0)
    assert t == pytest.approx(2 + 0.5 / 0.3, abs=0.11)


def test_slow_down_to_rest_ends_it() -> None:
    state = say(LISTENING, "square")
    for _ in range(2):
        state = say(state, "slow down", 0.1)
    assert not state.moving
    assert state.bounded is None


def test_again_repeats_the_last_command_that_moved() -> None:
    first = say(LISTENING, "again")
    assert not first.moving
    state = say(say(LISTENING, "one metre"), "point beer", 1.0)
    t, _ = until_rest(state, begin=0.0)
    rested = let_time_pass(state, t, SAFE).state
    again = say(rested, "again", t)
    assert again.motion.velocities() == (0.25, 0)
    assert again.bounded is not None


def test_again_repeats_all_of_it_and_goes_on_with_its_own_steps() -> None:
    square = say(LISTENING, "square")
    assert say(square, "again") == square
    once_more = say(square, "again, please")
    assert once_more.remaining_steps == (*square.remaining_steps, Step(say="once more"))


def test_a_motion_that_begins_with_words_takes_the_place_of_another_too() -> None:
    state = say(say(LISTENING, "one metre"), "on", 1.0)
    assert state.motion.velocities() == (0.1, 0)
    assert state.bounded is None


names = st.sampled_from(sorted(TABLE.sets[""]))
steps = st.one_of(
    st.builds(Step, drive=st.floats(0.05, 2), metres=st.floats(0.1, 5)),
    st.builds(Step, rotate=st.floats(-2, -0.05), degrees=st.floats(1, 720)),
    st.builds(Step, turn=st.floats(0.05, 2), seconds=st.floats(0.1, 60)),
    st.builds(Step, faster=st.floats(0.05, 2)),
    st.builds(Step, say=st.just("well")),
    st.builds(Step, state=st.sampled_from(["", "menu"])),
    st.builds(Step, confirm=st.just(True), drive=st.floats(0.05, 2)),
    st.builds(Step, again=st.just(True)),
)
written: st.SearchStrategy[CommandDefinition] = st.one_of(
    steps, st.tuples(steps), st.tuples(steps, steps)
)


@given(st.data())
def test_no_table_makes_a_state_from_which_stop_does_not_stop(data: st.DataObject) -> None:
    answers = {"yes": Step(answer=True), "no": Step(answer=False)}
    own = st.dictionaries(st.sampled_from(["a", "b", "c"]), written)
    settings = Config(
        commands={**answers, **data.draw(own)}, states={"menu": {**answers, **data.draw(own)}}
    )
    try:
        table = settings.table
    except ConfigError:
        reject()
    known = sorted({*table.sets[""], *table.sets["menu"]})
    state, t = State(listening=True), 0.0
    for name in data.draw(st.lists(st.sampled_from(known), max_size=20)):
        t += data.draw(st.floats(0, 30))
        state = let_time_pass(state, t, SAFE).state
        state = obey(state, GivenCommand(name, {}, t), table, SAFE).state
    for stop in ("stop", "stop speech"):
        rested = obey(state, GivenCommand(stop, {}, t), table, SAFE).state
        assert not rested.moving
        for later in range(1, 100):
            rested = let_time_pass(rested, t + later, SAFE).state
            assert not rested.moving
