"""From what was heard to what goes out, with time as an argument."""

from __future__ import annotations

import math
from collections.abc import Callable

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import convert
from msgspec.structs import replace

from voz.config import Config, default_commands
from voz.control.steps import Step
from voz.control.table import DEFAULT_STATE
from voz.errors import ConfigError, RobotError
from voz.events import Attention, Event, Notice, Partial, Reply, SelectedObject, Twist, Utterance
from voz.inbox import Renewal
from voz.run.controller import Controller
from voz.settings import Safety

COMMANDS = sorted(default_commands().sets[DEFAULT_STATE])
STOPPING = ("stop", "stop speech")


def heard(text: str, accepted: bool = True, now: float = 0) -> Utterance:
    return Utterance(now, text, 0.9, accepted, now, now, "microphone")


def perhaps(text: str) -> Partial:
    return Partial(0, text, 0.9)


def listening_controller(
    spoken: list[str] | None = None, safety: Safety | None = None
) -> tuple[Controller, list[Event]]:
    events: list[Event] = []
    controller = Controller([events.append], safety or Safety(), listening=True)
    for text in spoken or []:
        controller.hear(heard(text))
    return controller, events


def test_it_listens_when_it_is_told_to() -> None:
    controller = Controller([], Safety())
    assert not controller.listening
    controller.hear(heard("start speech"))
    assert controller.listening


@pytest.mark.parametrize("text", STOPPING)
def test_what_may_be_a_command_that_stops_halts_at_once(text: str) -> None:
    controller, events = listening_controller(["go forward"])
    controller.hear(perhaps(text))
    assert controller.velocities == (0, 0)
    assert events[-1] == perhaps(text)


@pytest.mark.parametrize("text", [c for c in COMMANDS if c not in STOPPING])
def test_what_may_be_any_other_command_changes_nothing(text: str) -> None:
    for spoken in ([], ["go forward"], ["rotate left", "speed up"]):
        controller, _ = listening_controller(spoken)
        before = controller.velocities
        controller.hear(perhaps(text))
        assert controller.velocities == before


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


def test_a_slow_down_that_would_stop_the_robot_halts_it_too() -> None:
    controller, _ = listening_controller(["go forward", "slow down"])
    controller.hear(perhaps("slow down"))
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


def test_everything_reaches_every_receiver_in_order() -> None:
    first: list[Event] = []
    second: list[Event] = []
    controller = Controller([first.append, second.append], Safety(), listening=True)
    controller.hear(heard("point beer"))
    controller.send(0.1)
    controller.zero(0.2)
    assert first == second
    assert first[1:] == [SelectedObject(0, 1), Twist(0.1, 0, 0), Twist(0.2, 0, 0)]


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
    controller.unwatched_sources.add("wyoming")
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
    controller.unwatched_sources.add("wyoming")
    controller.hear(replace(heard("go forward"), source=before))
    controller.hear(replace(heard("speed up", now=1.0), source=after))
    controller.hear(replace(heard("fold arm", now=2.0), source=before))  # changes no motion
    controller.send(5.9)
    assert controller.moving
    controller.send(6.0)
    assert controller.moving == goes_on


def test_whoever_says_again_what_it_does_already_says_whether_it_is_watched() -> None:
    controller, _ = listening_controller(["go forward"])
    controller.unwatched_sources.add("wyoming")
    controller.hear(unwatched("go forward", 1.0))
    controller.send(6.0)
    assert not controller.moving


def test_a_motion_with_an_end_of_its_own_needs_no_other_and_what_follows_it_does() -> None:
    steps = {"fetch": [{"drive": 0.1, "metres": 1}, {"drive": -0.1}]}
    table = convert({"commands": steps}, Config).table
    controller = Controller([], Safety(), True, table)
    controller.unwatched_sources.add("wyoming")
    controller.hear(unwatched("fetch", 0.0))
    controller.send(9.9)
    assert controller.velocities == (0.1, 0.0)
    controller.send(10.1)
    assert controller.velocities == (0.0, 0.0)


@pytest.mark.parametrize("now", [math.nan, math.inf, -math.inf, "3"])
def test_a_time_that_is_no_number_is_refused_and_ends_no_limit(now: float) -> None:
    table = Config(commands={"come here": Step(drive=0.1, metres=0.2)}).table
    events: list[Event] = []
    controller = Controller([events.append], Safety(motion_time_limit=9), True, table)
    controller.hear(heard("come here", now=1))
    for take_time in (controller.send, controller.zero):
        with pytest.raises(ConfigError):
            take_time(now)
    controller.send(2.9)
    assert controller.velocities == (0.1, 0)
    controller.send(3.0)
    assert events[-1] == Twist(3.0, 0, 0)


@pytest.mark.parametrize("stop", [Controller.stop, Controller.stop_by_hand])
def test_a_stop_at_no_time_stops_all_the_same(stop: Callable[..., None]) -> None:
    controller, events = listening_controller(["go forward"])
    with pytest.raises(ConfigError, match="the time of the run is nan; give seconds"):
        stop(controller, math.nan, "a key")
    controller.send(0.1)
    assert events[-1] == Twist(0.1, 0, 0)
    controller.stop(5.0, "lost")
    controller.hear(heard("go forward", now=4))  # said before
    assert controller.velocities == (0, 0)


def test_a_run_lasts_no_longer_than_a_time_can_be_written() -> None:
    controller, events = listening_controller()
    controller.send(1e12)
    assert events == [Twist(1e12, 0, 0)]
    with pytest.raises(ConfigError, match="the time of the run is 11"):
        controller.send(1.1e12)


@pytest.mark.parametrize(
    "arguments", [(None,), (Safety(), 1), (Safety(), True, {"stop": Step(stop=True)})]
)
def test_what_is_no_setting_is_refused(arguments: tuple[object, ...]) -> None:
    with pytest.raises(ConfigError, match="Expected"):
        Controller([], *arguments)  # type: ignore[arg-type]


def test_what_one_receiver_raises_keeps_nothing_from_the_others_and_is_raised_then() -> None:
    events: list[Event] = []
    errors = [BrokenPipeError("first"), SystemExit("second")]

    def fail(_: Event) -> None:
        raise errors[min(len(events), 1)]

    controller = Controller([fail, events.append, fail], Safety())
    with pytest.raises(BrokenPipeError, match="first"):
        controller.zero(1.0)
    assert events == [Twist(1.0, 0, 0)]


def test_in_another_process_than_its_own_it_sends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    controller, events = listening_controller()
    assert not controller.is_forked
    monkeypatch.setattr("os.getpid", lambda: -1)
    with pytest.raises(RobotError, match="a forked process does not drive"):
        controller.zero(1.0)
    assert events == []


def test_a_list_that_is_renewed_stops_the_robot_and_its_table_counts_from_then_on() -> None:
    own = {"advance": "go forward", "menu": Step(state="menu"), "again": Step(again=True)}
    before = Config(commands=own, states={"menu": {"advance": Step(drive=0.1)}}).table
    after = Config(commands={"advance": "go back", "again": Step(again=True)}).table
    events: list[Event] = []
    controller = Controller([events.append], Safety(), listening=True, table=before)
    controller.hear(heard("advance", now=1))
    controller.hear(heard("menu", now=1))
    controller.renew(2.0, Renewal("a list was saved", 2.0, under_way=True))
    told = "a list was saved: the robot stops"
    assert events[-1] == Notice(2.0, told, good=True, stops=True)
    assert not controller.moving
    controller.hear(heard("advance", now=2.5))
    assert not controller.moving
    controller.renew(3.0, Renewal("renewed", 3.0, under_way=False, table=after))
    assert events[-1] == Notice(3.0, "renewed", good=True)
    controller.hear(said("advance", 2.9, 3.5))  # begun before
    assert not controller.moving
    controller.hear(heard("again", now=4))  # nothing has moved yet
    assert not controller.moving
    controller.hear(heard("advance", now=5))
    assert controller.velocities == (-0.1, 0)


def test_a_list_that_could_not_be_renewed_leaves_the_table_and_is_no_good_news() -> None:
    controller, events = listening_controller()
    controller.renew(1.0, Renewal("a list was saved", 1.0, under_way=True))
    assert events == []  # it stood still
    controller.renew(2.0, Renewal("it is invalid", 2.0, under_way=False))
    assert events == [Notice(2.0, "it is invalid")]
    controller.renew(1.5, Renewal("late", 1.5, under_way=False))
    controller.hear(heard("go forward", now=1.9))
    assert not controller.moving
    controller.hear(heard("go forward", now=2.0))
    assert controller.moving


@pytest.mark.parametrize("odd", [math.nan, math.inf])
def test_odometry_that_is_no_place_ends_a_motion_by_its_velocity(odd: float) -> None:
    table = Config(commands={"turn round": Step(rotate=0.5, degrees=45)}).table
    controller = Controller([], Safety(), True, table, lambda _: (0.0, 0.0, odd))
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
    controller.stop_by_hand(2.0, "stopped by a key")
    assert controller.velocities == (0, 0)
    assert events[-1] == Notice(2.0, "stopped by a key", good=True, stops=True)
    controller.hear(heard("go forward", now=0.5))  # when it was pressed is not known
    assert controller.moving


def test_of_two_keys_the_later_counts_and_a_key_at_no_time_stops_too() -> None:
    controller, _ = listening_controller(["go forward"])
    with pytest.raises(ConfigError):
        controller.stop_by_hand(4.0, "stopped by a key", math.nan)
    assert not controller.moving
    for pressed in (3.0, 2.0):
        controller.stop_by_hand(4.0, "stopped by a key", pressed)
    controller.hear(heard("go forward", now=2.5))
    assert not controller.moving


def said(text: str, start: float, decided: float, source: str = "microphone") -> Utterance:
    return Utterance(decided, text, 0.9, True, start, decided - 0.3, source)


@pytest.mark.parametrize("ended", [1.8, 2.1])
def test_what_somebody_began_to_say_before_a_key_was_pressed_moves_nothing(ended: float) -> None:
    controller, events = listening_controller()
    controller.stop_by_hand(2.0, "stopped by a key", 2.0)
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
    controller.stop(1.0, "it is lost")
    controller.stop(2.0, "it is back", good=True)
    assert [e.stops for e in events if isinstance(e, Notice)] == [True, False]
    controller.hear(heard("go forward", now=1.9))
    assert not controller.moving
    controller.hear(heard("go forward", now=2.0))
    assert controller.moving


@given(st.lists(st.sampled_from(COMMANDS), max_size=20))
def test_in_a_rehearsal_all_is_told_and_nothing_moves(spoken: list[str]) -> None:
    controller, events = listening_controller()
    controller.rehearsing = True
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
    controller.rehearsing = True
    controller.hear(heard("stop"))
    assert controller.velocities == (0, 0)


ASKING = """
[commands]
"self destruct" = { confirm = true }
"tea for {cups}" = { drive = 0.2, confirm = "how many?" }
"yes" = { answer = true }
"no" = { answer = false }
"""


def asking_controller() -> tuple[Controller, list[Event]]:
    events: list[Event] = []
    table = convert(msgspec.toml.decode(ASKING), Config).table
    return Controller([events.append], Safety(), listening=True, table=table), events


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
    controller.name = "hey robot"
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
