"""The safety rules, each by itself and all together."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.config import default_commands
from voz.control.motion import Mode, Motion, apply_step
from voz.control.safety import (
    ends_goals,
    limit_velocities,
    motion_has_expired,
    slower_ends_at_zero,
    stop_listening_stops,
    zero_at_the_end,
)
from voz.control.state_machine import GivenCommand, State, obey
from voz.control.steps import Step
from voz.control.table import DEFAULT_STATE
from voz.events import Event, Notice, Partial, Twist, Utterance
from voz.settings import Safety

TABLE = default_commands()
SAFE = Safety()
BARE = Safety(enabled=False)
SLOWER = Step(slower=0.05)
commands = st.lists(st.sampled_from(sorted(TABLE.sets[DEFAULT_STATE])), max_size=60)
thousandths = st.integers(-2000, 2000)
motions = st.builds(Motion, thousandths, thousandths, st.sampled_from(Mode))


def after(state: State, command: str, safety: Safety = SAFE) -> State:
    return obey(state, GivenCommand(command), TABLE, safety).state


def run(spoken: list[str]) -> State:
    state = State(listening=True)
    for command in spoken:
        state = after(state, command)
    return state


def test_s1_stop_works_while_not_listening() -> None:
    moving = State(motion=Motion(linear=100))
    assert after(moving, "stop", BARE).moving
    assert not after(moving, "stop").moving


def test_s2_stop_speech_stops_the_robot() -> None:
    motion = Motion(linear=100, angular=-200)
    for listening in (True, False):
        moving = State(listening=listening, motion=motion)
        assert after(moving, "stop speech", BARE).moving
        assert not after(moving, "stop speech").moving
    assert not stop_listening_stops(Step(listen=False), motion).moving
    assert stop_listening_stops(Step(listen=True), motion) == motion


def test_s3_slow_down_does_not_start_a_rotation_from_standstill() -> None:
    still = State(listening=True, motion=Motion(mode=Mode.ROTATING))
    assert after(still, "slow down", BARE).motion.angular == 50
    assert after(still, "slow down").motion == still.motion


@given(before=motions)
def test_s3_slow_down_never_gets_faster_or_turns_round(before: Motion) -> None:
    slowed = slower_ends_at_zero(SLOWER, before, apply_step(before, SLOWER))
    assert abs(slowed.linear) <= abs(before.linear)
    assert abs(slowed.angular) <= abs(before.angular)
    assert slowed.linear * before.linear >= 0
    assert slowed.angular * before.angular >= 0


@given(motions, st.floats(0, 3), st.floats(0, 3))
def test_s4_no_motion_is_beyond_the_limits(motion: Motion, linear: float, angular: float) -> None:
    velocities = limit_velocities(motion, linear, angular).velocities()
    assert abs(velocities[0]) <= linear + 1e-6
    assert abs(velocities[1]) <= angular + 1e-6


def test_s4_a_limit_that_is_a_whole_step_is_reached() -> None:
    assert run(["go forward"] + ["speed up"] * 50).motion.velocities() == (0.5, 0.0)
    assert run(["turn right"] * 50).motion.velocities() == (0.0, -1.0)


def test_s6_motion_expires_only_with_a_limit_and_only_while_moving() -> None:
    limit = Safety(motion_time_limit=5)
    assert not motion_has_expired(True, 4.9, limit)
    assert motion_has_expired(True, 5.0, limit)
    assert motion_has_expired(True, 0.5, Safety(motion_time_limit=0.5))
    assert not motion_has_expired(False, 60, limit)
    assert not motion_has_expired(True, 60, SAFE)
    assert not motion_has_expired(True, 60, Safety(enabled=False, motion_time_limit=5))


@pytest.mark.parametrize("end", [KeyboardInterrupt, SystemExit, RuntimeError])
def test_s7_zero_is_published_last_whatever_ends_the_run(end: type[BaseException]) -> None:
    published: list[str] = []

    def program() -> None:
        with zero_at_the_end(lambda: published.append("zero")):
            published.append("cycle")
            raise end

    with pytest.raises(end):
        program()
    assert published == ["cycle", "zero"]


@given(commands)
def test_limits_hold_and_stop_stops_after_any_sequence(spoken: list[str]) -> None:
    state = run(spoken)
    linear, angular = state.motion.velocities()
    assert abs(linear) <= SAFE.max_linear
    assert abs(angular) <= SAFE.max_angular
    assert (linear * 20).is_integer()
    assert (angular * 20).is_integer()
    assert not after(state, "stop").moving


def obeyed(text: str, really: bool = True) -> Utterance:
    return Utterance(0, text, 1, True, 0, 0, "text", obeyed=really)


@pytest.mark.parametrize(
    "event", [obeyed("stop"), obeyed("stop speech"), Notice(0, "the robot stops", stops=True)]
)
def test_what_stops_the_robot_ends_the_goals_of_others_too(event: Event) -> None:
    assert ends_goals(event, TABLE.halts)


@pytest.mark.parametrize(
    "event",
    [
        obeyed("go forward"),
        obeyed("stop", really=False),
        Partial(0, "stop", 1),
        Twist(0, 0, 0),
        Notice(0, "it is back", good=True),
    ],
)
def test_nothing_else_does(event: Event) -> None:
    assert not ends_goals(event, TABLE.halts)
