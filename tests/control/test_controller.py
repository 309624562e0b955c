"""From what was heard to what goes out, with time as an argument."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import pytest
from controlled import Controlled
from hypothesis import given
from hypothesis import strategies as st
from msgspec import convert
from msgspec.structs import replace

from voz.config import Config, default_commands, with_examples
from voz.control.messages import Renewal
from voz.control.motion import Motion
from voz.control.state_machine import State
from voz.control.steps import Step
from voz.control.table import DEFAULT_STATE, command_table
from voz.events import (
    Attention,
    Event,
    Notice,
    Partial,
    ProgramEnded,
    Reply,
    SelectedObject,
    Twist,
    Utterance,
    to_json,
)
from voz.settings import Safety

COMMANDS = sorted(default_commands().sets[DEFAULT_STATE])
STOPPING = ("stop", "stop speech")


def heard(text: str, accepted: bool = True, now: float = 0) -> Utterance:
    return Utterance(now, text, 0.9, accepted, now, now, "microphone")


def perhaps(text: str) -> Partial:
    return Partial(0, text, 0.9)


def listening_controller(
    spoken: list[str] | None = None, safety: Safety | None = None
) -> tuple[Controlled, list[Event]]:
    controller = Controlled(safety)
    for text in spoken or []:
        controller.hear(heard(text))
    return controller, controller.events


def test_it_listens_when_it_is_told_to() -> None:
    controller = Controlled(listening=False)
    assert not controller.listening
    controller.hear(heard("start speech"))
    assert controller.listening


@pytest.mark.parametrize("text", STOPPING)
def test_what_may_be_a_command_that_stops_halts_at_once(text: str) -> None:
    controller, events = listening_controller(["go forward"])
    controller.hear(perhaps(text))
    assert controller.velocities == (0, 0)
    assert events[-1] == perhaps(text)


def test_which_of_two_stops_it_was_is_settled_later() -> None:
    controller, events = listening_controller(["go forward"])
    controller.hear(perhaps("stop"))
    assert controller.listening
    controller.hear(heard("stop speech"))
    assert not controller.listening
    assert controller.velocities == (0, 0)
    assert [e.text for e in events if isinstance(e, Reply)] == ["bep bep. I stop listening"]

    controller, _ = listening_controller(["go forward"])
    controller.hear(perhaps("stop"))
    controller.hear(heard("stop"))
    assert controller.listening


def test_a_stop_that_was_none_leaves_the_robot_at_rest() -> None:
    controller, _ = listening_controller(["go forward"])
    controller.hear(perhaps("stop"))
    controller.hear(heard("stop", accepted=False))
    assert controller.velocities == (0, 0)


@given(st.lists(st.sampled_from(COMMANDS), max_size=30), st.sampled_from(COMMANDS))
def test_after_a_partial_the_robot_holds_its_velocity_or_stands(
    spoken: list[str], text: str
) -> None:
    controller, _ = listening_controller(spoken)
    before = controller.velocities
    twin, _ = listening_controller([*spoken, text])
    controller.hear(perhaps(text))
    at_rest = twin.velocities == (0, 0)
    assert controller.velocities == ((0, 0) if at_rest else before)


@given(st.lists(st.sampled_from(COMMANDS), max_size=30), st.sampled_from(COMMANDS))
def test_a_command_that_was_first_a_partial_ends_where_it_would_have(
    spoken: list[str], text: str
) -> None:
    controller, _ = listening_controller(spoken)
    twin, _ = listening_controller([*spoken, text])
    controller.hear(perhaps(text))
    controller.hear(heard(text))
    assert (controller.velocities, controller.listening) == (twin.velocities, twin.listening)


@given(st.lists(st.sampled_from(COMMANDS), max_size=30))
def test_what_is_not_accepted_changes_nothing(spoken: list[str]) -> None:
    controller, _ = listening_controller(["go forward"])
    for text in spoken:
        controller.hear(heard(text, accepted=False))
    assert controller.velocities == (0.1, 0)


@pytest.mark.parametrize("wake", ["empieza a escuchar", ""])
def test_who_is_not_listened_to_is_told_what_of_the_list_begins_it(wake: str) -> None:
    steps = {"stop": Step(stop=True), "wake up": Step(listen=True)}
    table = command_table(steps, {}, examples={"wake up": wake, "stop": "stop"} if wake else {})
    controller = Controlled(listening=False, table=table)
    controller.hear(heard("go back"))
    (said,) = controller.events
    assert isinstance(said, Utterance)
    assert (said.ignored, said.say_first) == ("not_listening", wake)
    usual = Controlled(listening=False)
    usual.hear(heard("go back"))
    assert "say_first" not in to_json(usual.events[0])


def helped(listening: bool = True, **states: Any) -> Controlled:
    names = ["start speech", "stop", "yes", "no", "go back", "jump", "help", "hop", "next", "wave"]
    own = {
        "yes": {"answer": True}, "no": {"answer": False}, "jump": {"state": "menu"},
        "hop": {"confirm": True, "drive": 0.1},
    }  # fmt: skip
    states = {"menu": {"next": {"state": ""}}, **states}
    config = convert({"commands": own, "states": states}, Config)
    table = with_examples(config, {name: f"do {name}" for name in names}).table
    return Controlled(listening=listening, table=table)


def asked(name: str, spoken: bool) -> Utterance:
    return replace(heard(name), latency=0.1 if spoken else None)


@pytest.mark.parametrize(
    ("before", "listening", "told"),
    [
        ([], True, "do stop, do go back, do jump, do hop, do wave"),
        ([], False, "do start speech, do stop"),
        (["jump"], True, "do stop, do next"),
        (["hop"], True, "yes, no, do stop, do go back, do jump, do hop, do wave"),
    ],
)
@pytest.mark.parametrize("name", ["?", "help"])
def test_a_typed_help_tells_all_that_may_be_said_now(
    before: list[str], listening: bool, told: str, name: str
) -> None:
    controller = helped(listening)
    for command in before:
        controller.hear(heard(command))
    state = controller.state.robot
    controller.hear(asked(name, spoken=False))
    assert controller.events[-1] == Notice(0, f"you can say: {told}", good=True)
    assert controller.state.robot == state


def test_a_spoken_help_is_answered_by_three_commands_that_do_not_stop() -> None:
    controller = helped()
    controller.hear(asked("help", spoken=True))
    assert controller.events[-1] == Reply(0, "you can say do go back, do jump or do hop")
    asleep = helped(listening=False)
    asleep.hear(asked("help", spoken=True))
    (said,) = asleep.events
    assert isinstance(said, Utterance)
    assert (said.obeyed, said.ignored) == (False, "not_listening")
    assert said.say_first == "do start speech"
    menu = helped(menu={"wave": {"say": "hi"}})
    menu.hear(heard("jump"))
    menu.hear(asked("help", spoken=True))
    assert menu.events[-1] == Reply(0, "you can say do wave")
    for language, told in (("en", "you can say nothing"), ("es", "puedes decir nada")):
        nothing = Controlled(table=command_table({"stop": Step(stop=True)}, {}), language=language)
        nothing.hear(asked("help", spoken=True))
        assert nothing.events[-1] == Reply(0, told)


@pytest.mark.parametrize(
    ("many", "end"), [(11, "c10, stop"), (12, "c11 and 1 more"), (20, "c11 and 9 more")]
)
def test_of_very_many_commands_a_typed_help_tells_twelve(many: int, end: str) -> None:
    steps = {"stop": Step(stop=True), **{f"c{n:02}": Step(say="hi") for n in range(many)}}
    controller = Controlled(table=command_table(steps, {}))
    controller.hear(asked("?", spoken=False))
    said, last = controller.events[-2:]
    assert isinstance(said, Utterance)
    assert said.obeyed
    assert isinstance(last, Notice)
    assert last.text.endswith(end)


def test_a_help_of_the_settings_own_and_one_that_comes_too_late_tell_nothing() -> None:
    steps = {"stop": Step(stop=True), "help": Step(say="call Ada")}
    controller = Controlled(table=command_table(steps, {}))
    controller.hear(asked("help", spoken=True))
    assert controller.events[-1] == Reply(0, "call Ada")
    menu = Controlled(table=command_table(steps, {"menu": {"wave": Step(say="hi")}}))
    menu.hear(asked("help", spoken=True))
    assert menu.events[-1] == Reply(0, "call Ada")
    late = helped()
    late.hear(asked("help", spoken=False), late=True)
    assert [getattr(event, "obeyed", None) for event in late.events] == [False]


def test_s6_the_robot_stops_when_no_command_was_heard_for_long() -> None:
    controller, events = listening_controller(safety=Safety(motion_time_limit=2))
    controller.hear(heard("go back", now=1))
    controller.send(2.9)
    assert controller.velocities == (-0.1, 0)
    controller.send(3.0)
    assert controller.velocities == (0, 0)
    assert events[-2:] == [
        Notice(3.0, "no command for 2 s: the robot stops", stops=True),
        Twist(3.0, 0, 0),
    ]


def unwatched(text: str, now: float) -> Utterance:
    return replace(heard(text, now=now), source="wyoming")


def test_a_motion_that_nobody_watches_ends_after_five_seconds() -> None:
    controller, events = listening_controller()
    controller.change_rules(unwatched_sources=frozenset({"wyoming"}))
    controller.hear(unwatched("go forward", 1.0))
    controller.send(5.9)
    assert controller.velocities == (0.1, 0.0)
    controller.send(6.0)
    assert controller.velocities == (0.0, 0.0)
    assert events[-2] == Notice(6.0, "moved for 5 s with nobody there: the robot stops", stops=True)


@pytest.mark.parametrize(
    ("before", "after", "goes_on"),
    [
        ("microphone", "wyoming", False),  # who changed it last does not watch
        ("wyoming", "microphone", True),
        ("wyoming", "wyoming", False),
    ],
)
def test_who_changed_a_motion_last_says_whether_it_is_watched(
    before: str, after: str, goes_on: bool
) -> None:
    controller, _ = listening_controller()
    controller.change_rules(unwatched_sources=frozenset({"wyoming"}))
    controller.hear(replace(heard("go forward"), source=before))
    controller.hear(replace(heard("speed up", now=1.0), source=after))
    controller.hear(replace(heard("fold arm", now=2.0), source=before))  # changes no motion
    controller.send(5.9)
    assert controller.moving
    controller.send(6.0)
    assert controller.moving == goes_on


def test_whoever_says_again_what_it_does_already_says_whether_it_is_watched() -> None:
    controller, _ = listening_controller(["go forward"])
    controller.change_rules(unwatched_sources=frozenset({"wyoming"}))
    controller.hear(unwatched("go forward", 1.0))
    controller.send(6.0)
    assert not controller.moving


def test_a_motion_with_an_end_of_its_own_needs_no_other_and_what_follows_it_does() -> None:
    steps = {"fetch": [{"drive": 0.1, "metres": 1}, {"drive": -0.1}]}
    table = convert({"commands": steps}, Config).table
    controller = Controlled(table=table)
    controller.change_rules(unwatched_sources=frozenset({"wyoming"}))
    controller.hear(unwatched("fetch", 0.0))
    controller.send(9.9)
    assert controller.velocities == (0.1, 0.0)
    controller.send(10.1)
    assert controller.velocities == (0.0, 0.0)


def test_a_list_that_is_renewed_stops_the_robot_and_its_table_counts_from_then_on() -> None:
    own = {"advance": "go forward", "menu": Step(state="menu"), "again": Step(again=True)}
    before = Config(commands=own, states={"menu": {"advance": Step(drive=0.1)}}).table
    after = Config(commands={"advance": "go back", "again": Step(again=True)}).table
    controller = Controlled(table=before)
    events = controller.events
    controller.hear(heard("advance", now=1))
    controller.hear(heard("menu", now=1))
    controller.take(Renewal("a list was saved", 2.0, under_way=True), 2.0)
    told = "a list was saved: the robot stops"
    assert events[-1] == Notice(2.0, told, good=True, stops=True)
    assert not controller.moving
    controller.hear(heard("advance", now=2.5))
    assert not controller.moving
    controller.take(Renewal("renewed", 3.0, under_way=False, table=after), 3.0)
    assert events[-1] == Notice(3.0, "renewed", good=True)
    controller.hear(said("advance", 2.9, 3.5))  # begun before
    assert not controller.moving
    controller.hear(heard("again", now=4))  # nothing has moved yet
    assert not controller.moving
    controller.hear(heard("advance", now=5))
    assert controller.velocities == (-0.1, 0)


def test_a_list_that_could_not_be_renewed_leaves_the_table_and_is_no_good_news() -> None:
    controller, events = listening_controller()
    controller.take(Renewal("a list was saved", 1.0, under_way=True), 1.0)
    assert events == []  # it stood still
    controller.take(Renewal("it is invalid", 2.0, under_way=False), 2.0)
    assert events == [Notice(2.0, "it is invalid")]
    controller.take(Renewal("late", 1.5, under_way=False), 1.5)
    controller.hear(heard("go forward", now=1.9))
    assert not controller.moving
    controller.hear(heard("go forward", now=2.0))
    assert controller.moving


@pytest.mark.parametrize("odd", [math.nan, math.inf])
def test_odometry_that_is_no_place_ends_a_motion_by_its_velocity(odd: float) -> None:
    table = Config(commands={"turn round": Step(rotate=0.5, degrees=45)}).table
    controller = Controlled(table=table, odometry=lambda _: (0.0, 0.0, odd))
    controller.hear(heard("turn round"))
    controller.send(1.5)
    assert controller.velocities == (0, 0.5)
    controller.send(1.6)  # pi / 4 / 0.5 = 1.57
    assert controller.velocities == (0, 0)


@pytest.mark.parametrize("text", ["start speech", "stop speech", "stop", "slow down"])
def test_what_comes_too_late_may_still_end_the_motion_and_switch_the_listening(text: str) -> None:
    controller, events = listening_controller(["go forward", "slow down"])
    controller.hear(heard(text), late=True)
    (utterance,) = [e for e in events if isinstance(e, Utterance) and e.text == text][-1:]
    assert utterance.obeyed is (text != "start speech")  # which would leave it moving
    assert controller.velocities == ((0.05, 0) if text == "start speech" else (0, 0))
    controller.halt()
    controller.hear(heard("start speech"), late=True)
    assert controller.listening


@given(st.lists(st.sampled_from(COMMANDS), max_size=20), st.sampled_from(COMMANDS))
def test_what_comes_too_late_begins_no_motion_and_moves_no_arm(
    spoken: list[str], text: str
) -> None:
    controller, events = listening_controller(spoken)
    before, so_far = controller.velocities, len(events)
    controller.hear(heard(text), late=True)
    assert controller.velocities in (before, (0, 0))
    assert not any(isinstance(event, SelectedObject) for event in events[so_far:])


@given(st.sampled_from(COMMANDS))
def test_while_the_robot_speaks_only_stop_is_obeyed(text: str) -> None:
    controller, events = listening_controller(["go forward"])
    controller.hear(replace(heard(text), ignored="robot_speaking"))
    (utterance,) = events[len(events) - 1 :]
    assert isinstance(utterance, Utterance)
    assert utterance.obeyed is (text == "stop")
    assert controller.velocities == ((0, 0) if text == "stop" else (0.1, 0))


def test_a_key_stops_whatever_drives_the_robot() -> None:
    controller, events = listening_controller(["go forward"])
    controller.press(2.0)
    assert controller.velocities == (0, 0)
    assert events[-1] == Notice(2.0, "stopped by a key", good=True, stops=True)
    controller.hear(heard("go forward", now=0.5))  # when it was pressed is not known
    assert controller.moving


def test_of_two_keys_the_later_counts_and_a_key_at_no_time_stops_too() -> None:
    controller, _ = listening_controller(["go forward"])
    controller.press(4.0, pressed=math.nan)
    assert not controller.moving
    for pressed in (3.0, 2.0, math.nan):
        controller.press(4.0, pressed=pressed)
    controller.hear(heard("go forward", now=2.5))
    assert not controller.moving


def said(text: str, start: float, decided: float, source: str = "microphone") -> Utterance:
    return Utterance(decided, text, 0.9, True, start, decided - 0.3, source)


@pytest.mark.parametrize("ended", [1.8, 2.1])
def test_what_somebody_began_to_say_before_a_key_was_pressed_moves_nothing(ended: float) -> None:
    controller, events = listening_controller()
    controller.press(2.0, pressed=2.0)
    controller.hear(said("go forward", 1.4, ended + 0.3))
    assert controller.velocities == (0, 0)
    (utterance,) = [e for e in events if isinstance(e, Utterance)]
    assert (utterance.obeyed, utterance.ignored) == (False, "too_late")
    controller.hear(said("go forward", 2.0, 2.9))
    assert controller.velocities == (0.1, 0)


@given(st.floats(-10, 0))
def test_what_somebody_began_to_say_before_the_run_is_obeyed(start: float) -> None:
    controller, _ = listening_controller()
    controller.hear(said("go forward", start, 0.9))
    assert controller.velocities == (0.1, 0)


@pytest.mark.parametrize("text", STOPPING)
def test_what_was_begun_before_a_stop_from_elsewhere_and_settled_after_it_moves_nothing(
    text: str,
) -> None:
    controller, _ = listening_controller(["go back"])
    controller.hear(replace(said(text, 2.0, 2.0), source="text"))
    controller.hear(said("go forward", 1.5, 2.4))
    assert controller.velocities == (0, 0)
    controller.hear(said("start speech", 1.6, 2.5))
    controller.hear(said("go forward", 2.01, 3.0))
    assert controller.velocities == (0.1, 0)


def test_a_loss_stops_whatever_drives_the_robot_and_a_return_nothing() -> None:
    controller, events = listening_controller()
    controller.lose(1.0, "it is lost")
    controller.lose(2.0, None)
    assert [e.stops for e in events if isinstance(e, Notice)] == [True, False]
    controller.hear(heard("go forward", now=1.9))
    assert not controller.moving
    controller.hear(heard("go forward", now=2.0))
    assert controller.moving


@given(st.lists(st.sampled_from(COMMANDS), max_size=20))
def test_in_a_rehearsal_all_is_told_and_nothing_moves(spoken: list[str]) -> None:
    controller, events = listening_controller()
    controller.rehearse()
    for text in spoken:
        controller.hear(heard(text))
        controller.send(0)
    told = [event for event in events if isinstance(event, Utterance)]
    assert [event.text for event in told] == spoken
    assert all(event.obeyed == (event.text == "stop") for event in told)
    assert all(event.ignored == "rehearsal" for event in told if not event.obeyed)
    assert {type(event) for event in events} <= {Utterance, Twist}
    assert controller.velocities == (0, 0)
    assert controller.listening


def test_a_rehearsal_does_not_keep_stop_from_a_robot_that_moves() -> None:
    controller, _ = listening_controller(["go forward"])
    controller.rehearse()
    controller.hear(heard("stop"))
    assert controller.velocities == (0, 0)


ASKING = """
[commands]
"self destruct" = { confirm = true }
"tea for {cups}" = { drive = 0.2, confirm = "how many?" }
"yes" = { answer = true }
"no" = { answer = false }
"""


def asking_controller() -> tuple[Controlled, list[Event]]:
    controller = Controlled(table=convert(msgspec.toml.decode(ASKING), Config).table)
    return controller, controller.events


def obeyed(events: list[Event]) -> list[str]:
    return [event.text for event in events if isinstance(event, Utterance) and event.obeyed]


@pytest.mark.parametrize("answer", ["no", "go back", "stop", None])
def test_what_asks_first_is_obeyed_by_nobody_without_a_yes(answer: str | None) -> None:
    controller, events = asking_controller()
    controller.hear(heard("self destruct", now=1))
    said = events[0]
    assert isinstance(said, Utterance)
    assert (said.obeyed, said.ignored) == (False, "asked_first")
    if answer:
        controller.hear(heard(answer, now=2))
    controller.send(20)
    controller.hear(heard("yes", now=21))
    assert obeyed(events) == ([answer] if answer else [])


def test_a_yes_does_what_was_asked_once_with_its_slots() -> None:
    controller, events = asking_controller()
    said = replace(heard("tea for two", now=1), command="tea for {cups}", slots={"cups": 2})
    controller.hear(said)
    assert not controller.moving
    controller.hear(heard("yes", now=2))
    controller.hear(heard("yes", now=3))
    (done,) = [event for event in events if isinstance(event, Utterance) and event.obeyed]
    assert (done.text, done.command, done.slots) == ("tea for two", said.command, {"cups": 2})
    assert controller.velocities == (0.2, 0)


def test_a_late_yes_does_nothing() -> None:
    controller, events = asking_controller()
    controller.hear(heard("self destruct", now=1))
    controller.hear(heard("yes", now=2), late=True)
    assert obeyed(events) == []


def test_while_it_is_asked_receivers_know_what_may_be_answered() -> None:
    controller, events = asking_controller()
    for text in ("self destruct", "no"):
        controller.hear(heard(text, now=1))
    answers = [event.answers for event in events if isinstance(event, Attention)]
    assert answers == [("yes", "no"), ()]


def test_a_robot_with_a_name_stays_awake_for_the_answer_to_what_asks_first() -> None:
    controller, events = asking_controller()
    controller.change_rules(name="hey robot")
    spoken = {"source": "microphone", "latency": 0.2}
    controller.hear(replace(heard("self destruct", now=1), named=True, **spoken))
    controller.send(9.5)
    controller.hear(replace(heard("yes", now=10), **spoken))
    assert obeyed(events) == ["self destruct"]


def test_what_only_a_robot_s_own_code_knows_comes_not_too_late_either() -> None:
    controller, events = listening_controller()
    controller.hear(heard("wave"), late=True)
    assert obeyed(events) == []


def test_what_a_recognizer_with_a_name_hears_without_it_moves_no_controller() -> None:
    controller, events = listening_controller()
    said = replace(heard("go forward", now=1), latency=0.2, named=False)
    controller.hear(said)
    assert not controller.moving
    controller.hear(replace(said, text="stop", command="stop"))
    controller.hear(replace(said, t=3, start=3, named=True))
    assert obeyed(events) == ["stop", "go forward"]
    controller.hear(replace(said, t=4, start=4, text="go back", command="go back"))
    assert controller.velocities == (-0.1, 0)


def go_forward(t: float, source: str = "text") -> Utterance:
    return Utterance(t, "go forward", 1.0, True, t, t, source)


def warnings(controller: Controlled) -> list[str]:
    return [event.text for event in controller.events if isinstance(event, Notice)]


def test_a_stop_at_a_time_makes_late_what_was_said_before() -> None:
    controller, events = listening_controller(["go forward"])
    controller.stop(5.0, "control loop stalled")
    assert events[-1] == Notice(5.0, "control loop stalled", stops=True)
    controller.hear(heard("go forward", now=4))  # said before
    assert controller.velocities == (0, 0)


def test_s5_a_lost_robot_stops_the_motion_and_is_named_once() -> None:
    controller, _ = listening_controller(["go forward"])
    controller.lose(0.1, None, "ros2")
    assert controller.velocities == (0.1, 0)
    for t in (0.2, 0.3):
        controller.lose(t, "the robot ros2 is lost (nobody listens)", "ros2")
        assert controller.velocities == (0, 0)
    assert warnings(controller) == ["the robot ros2 is lost (nobody listens): the robot stops"]


def test_s5_what_was_said_while_it_was_lost_does_not_move_it_when_it_is_back() -> None:
    controller, events = listening_controller()
    controller.lose(0.0, "gone", "ros1")
    controller.hear(go_forward(0.1))
    controller.lose(0.2, None, "ros1")
    assert controller.velocities == (0, 0)
    assert warnings(controller)[-1] == "ros1 is there; the robot waits for a command"
    assert [event.good for event in events if isinstance(event, Notice)] == [False, True]
    controller.hear(go_forward(0.3))
    controller.lose(0.4, None, "ros1")
    assert controller.velocities == (0.1, 0)


def test_s5_the_second_of_two_that_are_lost_stops_it_too() -> None:
    controller, _ = listening_controller()
    controller.lose(0.0, "gone", "ros1")
    controller.hear(go_forward(0.1))  # for the other one
    controller.lose(0.2, "gone too", "ros2")
    assert controller.velocities == (0, 0)
    assert warnings(controller) == ["gone: the robot stops", "gone too: the robot stops"]


@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=50))
def test_s5_motion_ends_with_every_change_and_goes_on_without_one(
    steps: list[tuple[bool, bool, bool]],
) -> None:
    controller, _ = listening_controller()
    before = (False, False)
    for t, (a, b, command) in enumerate(steps):
        if command:
            controller.hear(go_forward(t))
        moving = controller.velocities
        for name, lost in (("a", a), ("b", b)):
            controller.lose(t, "lost" if lost else None, name)
        assert controller.velocities == ((0, 0) if (a, b) != before else moving)
        before = (a, b)


def test_s5_commands_of_a_lost_source_are_late_until_it_is_back() -> None:
    controller, events = listening_controller()
    controller.lose(1.0, "gone", "page", "page", "browser")
    for source, moves in (("page", False), ("browser", False), ("text", True)):
        controller.hear(go_forward(1.1, source))
        assert controller.moving == moves
    told = [event for event in events if isinstance(event, Utterance)]
    assert [event.ignored for event in told] == ["too_late", "too_late", None]
    controller.lose(1.2, None, "page", "page", "browser")
    controller.hear(go_forward(1.3, "browser"))
    assert controller.moving


def test_s5_a_source_with_two_losses_is_heard_again_when_both_are_over() -> None:
    controller, _ = listening_controller()

    def moves(t: float, page: str | None, microphone: str | None) -> bool:
        controller.lose(t, page, "page", "page", "browser")
        controller.lose(t, microphone, "hearing", "browser")
        controller.hear(go_forward(t, "browser"))
        return controller.moving

    assert not moves(1, "gone", "no sound comes")
    assert not moves(2, None, "no sound comes")
    assert moves(3, None, None)


def set_going(controller: Controlled) -> None:
    """Let it move without a command, as by a fault in voz."""
    controller.state = replace(
        controller.state, robot=State(listening=True, motion=Motion(linear=100))
    )


def test_s5_while_it_is_lost_what_moves_the_robot_without_a_command_is_stopped_again() -> None:
    controller, _ = listening_controller()
    for t in (0.1, 0.2, 0.3):
        controller.lose(t, "gone", "page", "page")
        assert not controller.moving
        set_going(controller)
    assert warnings(controller) == ["gone: the robot stops"] * 3


@pytest.mark.parametrize(("source", "goes_on"), [("text", True), ("page", False)])
def test_s5_while_it_is_lost_a_command_from_elsewhere_alone_goes_on(
    source: str, goes_on: bool
) -> None:
    controller, _ = listening_controller()
    controller.lose(0.1, "gone", "page", "page")
    controller.hear(go_forward(0.2, "text"))
    controller.lose(0.3, "gone", "page", "page")
    assert controller.moving
    # The last command that had an effect says who commands; a late stop has one.
    controller.hear(replace(heard("stop", now=0.4), source=source))
    set_going(controller)
    controller.lose(0.5, "gone", "page", "page")
    assert controller.moving == goes_on


def test_s5_what_was_commanded_before_a_loss_does_not_go_on_after_it() -> None:
    controller, _ = listening_controller()
    controller.hear(go_forward(0.1))
    controller.lose(0.2, "gone", "page", "page")
    set_going(controller)
    controller.lose(0.3, "gone", "page", "page")
    assert not controller.moving


def test_what_others_have_to_say_is_handed_on_and_changes_nothing() -> None:
    controller, events = listening_controller(["go forward"])
    before = controller.state
    others = [Notice(1.0, "0.30 s of sound were lost"), ProgramEnded(1.0, "dance")]
    for other in others:
        controller.take(other, 1.0)
    assert events[-2:] == others
    assert controller.state == before


def test_once_a_name_was_listened_for_what_lacks_it_in_doubt_wakes_nobody() -> None:
    controller, events = listening_controller()
    doubtful = replace(heard("go back", accepted=False, now=1), named=False, latency=0.2)
    controller.hear(doubtful)
    assert Attention(1.0, awake=False) in events
    controller.hear(replace(heard("go forward", now=2), latency=0.2))
    assert not controller.moving
