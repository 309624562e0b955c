"""The command rules, against the table and against a copy of how the original was written."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.config import Config, default_commands
from voz.control.motion import Mode, Motion
from voz.control.state_machine import GivenCommand, State, Transition, let_time_pass
from voz.control.state_machine import obey as obeyed
from voz.control.steps import Step
from voz.control.table import DEFAULT_STATE
from voz.events import CallFunction, Notice, Play, Publish, Reply, SelectedObject, StartProgram
from voz.settings import Safety

TABLE = default_commands()
COMMANDS = tuple(TABLE.sets[DEFAULT_STATE])
STARTED, STOPPED = TABLE.replies
OBJECT_NUMBERS = {"point beer": 1, "point cocacola": 2, "fold arm": 100}
BARE = Safety(enabled=False)
MOVING = State(listening=True, motion=Motion(linear=100))

commands = st.lists(st.sampled_from([*COMMANDS, "open the door"]), max_size=60)


def obey(state: State, command: str) -> Transition:
    return obeyed(state, GivenCommand(command), TABLE, BARE)


def drive(*spoken: str) -> State:
    state = State(listening=True)
    for command in spoken:
        state = obey(state, command).state
    return state


def velocities(*spoken: str) -> tuple[float, float]:
    return drive(*spoken).motion.velocities()


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
        assert state.motion.velocities() == pytest.approx(
            (original.linear, original.angular), abs=1e-3
        )
        assert state.listening == original.listening


@pytest.mark.parametrize("command", [c for c in COMMANDS if c != "start speech"])
def test_nothing_is_obeyed_before_start_speech(command: str) -> None:
    assert obey(State(), command) == Transition(State(), (), False, "not_listening")


def test_an_unknown_sentence_changes_nothing() -> None:
    assert obey(MOVING, "open the door") == Transition(MOVING, (), True, None)


def test_start_and_stop_speech_reply_once_each() -> None:
    state, replies = State(), []
    for command in ["stop speech", "start speech", "start speech", "stop speech", "stop speech"]:
        state, events, *_ = obey(state, command)
        replies.append(events)
    assert replies == [(), (Reply(0, STARTED),), (), (Reply(0, STOPPED),), ()]


@pytest.mark.parametrize(("command", "value"), OBJECT_NUMBERS.items())
def test_an_object_is_selected_once_and_the_motion_goes_on(command: str, value: int) -> None:
    assert obey(MOVING, command) == Transition(MOVING, (SelectedObject(0, value),), True, None)


def test_stop_keeps_the_mode() -> None:
    assert drive("rotate left", "stop").motion.mode is Mode.ROTATING


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


LAMPS = Config(
    commands={
        "light": Step(publish=True, topic="lamp", say="it is light"),
        "knife": Step(publish="knife", topic="bring", confirm="the knife?"),
        "drive on": (Step(drive=0.1, confirm=True), Step(say="here I go")),
        "once more": Step(again=True),
        "yes": Step(answer=True, say="well"),
        "no": Step(answer=False),
        "menu": Step(state="menu"),
        "tea": Step(run=("echo", "{cups}"), seconds=2, play="backing-up"),
    },
    states={"menu": {"coffee": Step(call=("bar:coffee", "{cups}")), "back": Step(state="")}},
).table
LISTENING = State(listening=True)


def say(state: State, name: str, t: float = 0.0, **slots: str | float) -> Transition:
    return obeyed(state, GivenCommand(name, slots, t), LAMPS, Safety())


def test_a_step_publishes_and_speaks() -> None:
    events = (Publish(1, "lamp", True), Reply(1, "it is light"))
    assert say(LISTENING, "light", 1) == Transition(LISTENING, events, True, None)


def test_a_program_and_a_function_get_the_slots() -> None:
    assert say(LISTENING, "tea", cups=2.0).events == (
        StartProgram(0, ("echo", "2"), 2),
        Play(0, "backing-up"),
    )
    menu = say(LISTENING, "menu").state
    assert say(menu, "coffee", cups=2.0).events == (CallFunction(0, "bar:coffee", (2.0,)),)


def test_a_slot_that_was_not_said_is_a_warning_and_nothing_is_done() -> None:
    transition = say(LISTENING, "tea")
    assert not transition.obeyed
    assert transition.state == LISTENING
    assert transition.events == (Notice(0, '"tea" cannot be done: nothing was said for {cups}'),)


def test_each_state_has_its_own_commands_and_what_stops_is_in_all() -> None:
    menu = say(MOVING, "menu").state
    assert menu.motion == MOVING.motion
    assert say(menu, "go back") == Transition(menu, (), False, "not_now")
    assert not say(menu, "stop").state.moving
    assert say(menu, "stop").state.commands == "menu"
    assert say(menu, "back").state == MOVING
    assert say(menu, "stop speech").state == State()


def test_what_is_to_be_confirmed_waits_for_a_yes() -> None:
    asked = say(LISTENING, "drive on", 1)
    assert asked.events == (Reply(1, "drive on?"),)
    assert not asked.state.moving
    done = say(asked.state, "yes", 2)
    assert done.events == (Reply(2, "well"), Reply(2, "here I go"))
    assert done.state.motion.velocities() == (0.1, 0)
    assert say(done.state, "yes", 3).ignored == "nothing_asked"


def test_what_asks_first_asks_again_before_it_is_repeated() -> None:
    asked = say(LISTENING, "drive on", 1)
    done = say(asked.state, "yes", 2)
    rested = say(done.state, "stop", 3).state
    again = say(rested, "once more", 4)
    assert again.events == (Reply(4, "once more?"),)
    assert not again.state.moving
    assert say(again.state, "yes", 5).state.motion.velocities() == (0.1, 0)


def test_a_no_another_command_or_silence_takes_it_back() -> None:
    asked = say(LISTENING, "knife", 1)
    assert asked.events == (Reply(1, "the knife?"),)
    assert say(asked.state, "no", 2) == Transition(LISTENING, (), True, None)
    assert say(say(asked.state, "light", 2).state, "yes", 3).ignored == "nothing_asked"
    assert say(asked.state, "yes", 11).confirmed == GivenCommand("knife", {}, 11)
    assert say(asked.state, "yes", 11.1).ignored == "nothing_asked"
    assert let_time_pass(asked.state, 11, Safety()) == Transition(asked.state, (), True, None)
    told = Notice(11.1, 'no answer: "knife" is not done')
    assert let_time_pass(asked.state, 11.1, Safety()) == Transition(LISTENING, (told,), True, None)
