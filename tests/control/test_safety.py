"""The safety rules, each by itself and all together."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.config import Safety
from voz.control.controller import OBJECTS, RULES, Mode, State, obey
from voz.control.safety import (
    ends_goals,
    limited,
    motion_has_expired,
    obey_safely,
    slow_down_ends_at_zero,
    stop_always_works,
    stop_speech_stops,
    zero_at_the_end,
)
from voz.events import Event, Partial, Twist, Utterance, Warning

SAFE = Safety()
BARE = Safety(enabled=False)
commands = st.lists(st.sampled_from([*RULES, *OBJECTS, "start speech", "stop speech"]), max_size=60)
steps = st.integers(-40, 40)
states = st.builds(State, st.booleans(), steps, steps, st.sampled_from(Mode))


def run(spoken: list[str], safety: Safety) -> State:
    state = State(listening=True)
    for command in spoken:
        state = obey_safely(state, command, safety).state
    return state


def test_s1_stop_works_while_not_listening() -> None:
    moving = State(listening=False, linear=2)
    assert obey(moving, "stop").state.moving
    assert not stop_always_works("stop", moving).moving
    assert not obey_safely(moving, "stop", SAFE).state.moving


def test_s2_stop_speech_stops_the_robot() -> None:
    moving = State(listening=True, linear=2, angular=-4)
    assert obey(moving, "stop speech").state.moving
    assert not stop_speech_stops("stop speech", moving).moving
    assert not obey_safely(moving, "stop speech", SAFE).state.moving


def test_s3_slow_down_does_not_start_a_rotation_from_standstill() -> None:
    still = State(listening=True, mode=Mode.ROTATING)
    assert obey(still, "slow down").state.angular == 1
    assert obey_safely(still, "slow down", SAFE).state == still


@given(before=states)
def test_s3_slow_down_never_gets_faster_or_turns_round(before: State) -> None:
    after = slow_down_ends_at_zero("slow down", before, obey(before, "slow down").state)
    assert abs(after.linear) <= abs(before.linear)
    assert abs(after.angular) <= abs(before.angular)
    assert after.linear * before.linear >= 0
    assert after.angular * before.angular >= 0


@given(states, st.floats(0, 3), st.floats(0, 3))
def test_s4_no_state_is_beyond_the_limits(state: State, linear: float, angular: float) -> None:
    velocities = limited(state, linear, angular).velocities()
    assert abs(velocities[0]) <= linear
    assert abs(velocities[1]) <= angular


def test_s4_a_limit_that_is_a_whole_step_is_reached() -> None:
    assert run(["go forward"] + ["speed up"] * 50, SAFE).velocities() == (0.5, 0.0)
    assert run(["turn right"] * 50, SAFE).velocities() == (0.0, -1.0)


def test_s6_motion_expires_only_with_a_limit_and_only_while_moving() -> None:
    moving, limit = State(linear=2), Safety(motion_time_limit=5)
    assert not motion_has_expired(moving, 4.9, limit)
    assert motion_has_expired(moving, 5.0, limit)
    assert not motion_has_expired(State(), 60, limit)
    assert not motion_has_expired(moving, 60, SAFE)
    assert not motion_has_expired(moving, 60, Safety(enabled=False, motion_time_limit=5))


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
    state = run(spoken, SAFE)
    linear, angular = state.velocities()
    assert abs(linear) <= SAFE.max_linear
    assert abs(angular) <= SAFE.max_angular
    assert (linear * 20).is_integer()
    assert (angular * 20).is_integer()
    assert not obey_safely(state, "stop", SAFE).state.moving


@given(states, commands)
def test_without_safety_it_is_the_bare_rules(state: State, spoken: list[str]) -> None:
    for command in spoken:
        assert obey_safely(state, command, BARE) == obey(state, command)
        state = obey(state, command).state


def obeyed(text: str, really: bool = True) -> Utterance:
    return Utterance(0, text, 1, True, 0, 0, "text", obeyed=really)


@pytest.mark.parametrize(
    "event", [obeyed("stop"), obeyed("stop speech"), Warning(0, "the robot stops", stops=True)]
)
def test_what_stops_the_robot_ends_the_goals_of_others_too(event: Event) -> None:
    assert ends_goals(event)


@pytest.mark.parametrize(
    "event",
    [
        obeyed("go forward"),
        obeyed("stop", really=False),
        Partial(0, "stop", 1),
        Twist(0, 0, 0),
        Warning(0, "it is back", good=True),
    ],
)
def test_nothing_else_does(event: Event) -> None:
    assert not ends_goals(event)
