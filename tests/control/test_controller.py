"""The command rules, against the table and against a copy of how the original was written."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.control.controller import COMMANDS, OBJECTS, STARTED, STOPPED, Mode, State, obey

commands = st.lists(st.sampled_from([*COMMANDS, "open the door"]), max_size=60)


def drive(*spoken: str) -> State:
    state = State(listening=True)
    for command in spoken:
        state = obey(state, command).state
    return state


def velocities(*spoken: str) -> tuple[float, float]:
    return drive(*spoken).velocities()


class Original:
    """The table of the design, written with two flags and floats as the first program was."""

    def __init__(self) -> None:
        self.listening = self.turning = self.rotating = False
        self.linear = self.angular = 0.0

    def hear(self, command: str) -> None:
        if command == "start speech":
            self.listening = True
        if not self.listening:
            return
        if command == "stop speech":
            self.listening = False
        elif command == "stop":
            self.linear = self.angular = 0.0
        elif command == "go forward":
            self.linear, self.angular = 0.1, 0.0
        elif command == "go back":
            self.linear, self.angular = -0.1, 0.0
        elif command == "turn left":
            if self.angular <= 0.001 or self.rotating:
                self.angular, self.turning = 0.1, True
            else:
                self.angular += 0.1
            self.rotating = False
        elif command == "turn right":
            if self.angular >= -0.001 or self.rotating:
                self.angular, self.turning = -0.1, True
            else:
                self.angular -= 0.1
            self.rotating = False
        elif command == "rotate left":
            self.linear = 0.0
            if self.angular <= 0.001 or self.turning:
                self.angular, self.rotating = 0.1, True
            self.turning = False
        elif command == "rotate right":
            self.linear = 0.0
            if self.angular >= -0.001 or self.turning:
                self.angular, self.rotating = -0.1, True
            self.turning = False
        elif command == "speed up":
            if abs(self.linear) < 0.001:
                if self.rotating:
                    self.angular += 0.05 if self.angular > 0.001 else -0.05
            else:
                self.linear += 0.05 if self.linear > 0 else -0.05
        elif command == "slow down":
            if abs(self.linear) < 0.001:
                if self.rotating:
                    self.angular -= 0.05 if self.angular > 0.001 else -0.05
            else:
                self.linear -= 0.05 if self.linear > 0 else -0.05


@given(commands)
def test_the_rules_move_as_the_original_program_did(spoken: list[str]) -> None:
    state, original = State(), Original()
    for command in spoken:
        state = obey(state, command).state
        original.hear(command)
        assert state.velocities() == pytest.approx((original.linear, original.angular), abs=1e-3)
        assert state.listening == original.listening


@given(commands)
def test_velocities_are_exact_multiples_of_a_twentieth(spoken: list[str]) -> None:
    for velocity in velocities(*spoken):
        assert velocity == round(velocity, 2)
        assert (velocity * 20).is_integer()


@given(commands)
def test_stop_stops(spoken: list[str]) -> None:
    state = obey(drive(*spoken, "start speech"), "stop").state
    assert not state.moving


@pytest.mark.parametrize("command", [c for c in COMMANDS if c != "start speech"])
def test_nothing_is_obeyed_before_start_speech(command: str) -> None:
    assert obey(State(), command) == (State(), None, None, False)


def test_an_unknown_sentence_changes_nothing() -> None:
    state = State(listening=True, linear=2)
    assert obey(state, "open the door") == (state, None, None, state.listening)


def test_start_and_stop_speech_reply_once_each() -> None:
    state, replies = State(), []
    for command in ["stop speech", "start speech", "start speech", "stop speech", "stop speech"]:
        state, _, reply, _ = obey(state, command)
        replies.append(reply)
    assert replies == [None, STARTED, None, STOPPED, None]


@pytest.mark.parametrize(("command", "value"), OBJECTS.items())
def test_an_object_is_selected_once_and_the_motion_goes_on(command: str, value: int) -> None:
    moving = State(listening=True, linear=2)
    assert obey(moving, command) == (moving, value, None, True)


def test_stop_keeps_the_mode() -> None:
    assert drive("rotate left", "stop").mode is Mode.ROTATING


@pytest.mark.parametrize(
    ("spoken", "expected"),
    [
        (["go forward"], (0.1, 0.0)),
        (["go back"], (-0.1, 0.0)),
        (["turn left"], (0.0, 0.1)),
        (["turn left", "turn left"], (0.0, 0.2)),
        (["turn left", "turn right"], (0.0, -0.1)),
        (["go forward", "turn right"], (0.1, -0.1)),
        (["turn left", "go forward"], (0.1, 0.0)),
        (["turn left", "turn left", "rotate left"], (0.0, 0.1)),
        (["rotate left", "rotate left"], (0.0, 0.1)),
        (["go forward", "rotate right"], (0.0, -0.1)),
        (["rotate left", "turn left"], (0.0, 0.1)),
        (["go forward", "speed up"], (0.15, 0.0)),
        (["go back", "speed up"], (-0.15, 0.0)),
        (["go back", "slow down"], (-0.05, 0.0)),
        (["turn left", "speed up"], (0.0, 0.1)),
        (["rotate right", "speed up"], (0.0, -0.15)),
        (["rotate left", "stop", "speed up"], (0.0, -0.05)),
        (["rotate left", "stop", "slow down"], (0.0, 0.05)),
        (["speed up"], (0.0, 0.0)),
    ],
)
def test_the_table(spoken: list[str], expected: tuple[float, float]) -> None:
    assert velocities(*spoken) == expected
