"""From what was heard to what goes out, with time as an argument."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from voz.config import Config, usual_commands
from voz.control.steps import Step
from voz.control.table import USUAL
from voz.errors import ConfigError
from voz.events import Event, Partial, Reply, SelectedObject, Twist, Utterance, Warning
from voz.run.controller import Controller
from voz.settings import Safety

COMMANDS = sorted(usual_commands().sets[USUAL])
STOPPING = ("stop", "stop speech")


def heard(text: str, accepted: bool = True, now: float = 0) -> Utterance:
    return Utterance(now, text, 0.9, accepted, now, now, "microphone")


def perhaps(text: str) -> Partial:
    return Partial(0, text, 0.9)


def listening_drive(
    spoken: list[str] | None = None, safety: Safety | None = None
) -> tuple[Controller, list[Event]]:
    events: list[Event] = []
    drive = Controller([events.append], safety or Safety(), listening=True)
    for text in spoken or []:
        drive.hear(heard(text))
    return drive, events


@pytest.mark.parametrize("text", STOPPING)
def test_what_may_be_a_command_that_stops_halts_at_once(text: str) -> None:
    drive, _ = listening_drive(["go forward"])
    drive.hear(perhaps(text))
    assert drive.velocities == (0, 0)


@pytest.mark.parametrize("text", [c for c in COMMANDS if c not in STOPPING])
def test_what_may_be_any_other_command_changes_nothing(text: str) -> None:
    for spoken in ([], ["go forward"], ["rotate left", "speed up"]):
        drive, _ = listening_drive(spoken)
        before = drive.velocities
        drive.hear(perhaps(text))
        assert drive.velocities == before


def test_which_of_two_stops_it_was_is_settled_later() -> None:
    drive, events = listening_drive(["go forward"])
    drive.hear(perhaps("stop"))
    assert drive.listening
    drive.hear(heard("stop speech"))
    assert not drive.listening
    assert drive.velocities == (0, 0)
    assert [e.text for e in events if isinstance(e, Reply)] == ["bep bep. I stop listening"]

    drive, _ = listening_drive(["go forward"])
    drive.hear(perhaps("stop"))
    drive.hear(heard("stop"))
    assert drive.listening


def test_a_stop_that_was_none_leaves_the_robot_at_rest() -> None:
    drive, _ = listening_drive(["go forward"])
    drive.hear(perhaps("stop"))
    drive.hear(heard("stop", accepted=False))
    assert drive.velocities == (0, 0)


def test_a_slow_down_that_would_stop_the_robot_halts_it_too() -> None:
    drive, _ = listening_drive(["go forward", "slow down"])
    drive.hear(perhaps("slow down"))
    assert drive.velocities == (0, 0)


@given(st.lists(st.sampled_from(COMMANDS), max_size=30), st.sampled_from(COMMANDS))
def test_after_a_partial_the_robot_holds_its_velocity_or_stands(
    spoken: list[str], text: str
) -> None:
    drive, _ = listening_drive(spoken)
    before = drive.velocities
    twin, _ = listening_drive([*spoken, text])
    drive.hear(perhaps(text))
    at_rest = twin.velocities == (0, 0)
    assert drive.velocities == ((0, 0) if at_rest else before)


@given(st.lists(st.sampled_from(COMMANDS), max_size=30), st.sampled_from(COMMANDS))
def test_a_command_that_was_first_a_partial_ends_where_it_would_have(
    spoken: list[str], text: str
) -> None:
    drive, _ = listening_drive(spoken)
    twin, _ = listening_drive([*spoken, text])
    drive.hear(perhaps(text))
    drive.hear(heard(text))
    assert (drive.velocities, drive.listening) == (twin.velocities, twin.listening)


@given(st.lists(st.sampled_from(COMMANDS), max_size=30))
def test_what_is_not_accepted_changes_nothing(spoken: list[str]) -> None:
    drive, _ = listening_drive(["go forward"])
    for text in spoken:
        drive.hear(heard(text, accepted=False))
    assert drive.velocities == (0.1, 0)


def test_everything_reaches_every_receiver_in_order() -> None:
    first: list[Event] = []
    second: list[Event] = []
    drive = Controller([first.append, second.append], Safety(), listening=True)
    drive.hear(heard("point beer"))
    drive.send(0.1)
    drive.zero(0.2)
    assert first == second
    assert first[1:] == [SelectedObject(0, 1), Twist(0.1, 0, 0), Twist(0.2, 0, 0)]


def test_s6_the_robot_stops_when_no_command_was_heard_for_long() -> None:
    drive, events = listening_drive(safety=Safety(motion_time_limit=2))
    drive.hear(heard("go back", now=1))
    drive.send(2.9)
    assert drive.velocities == (-0.1, 0)
    drive.send(3.0)
    assert drive.velocities == (0, 0)
    assert events[-2:] == [
        Warning(3.0, "no command for 2 s: the robot stops", stops=True),
        Twist(3.0, 0, 0),
    ]


@pytest.mark.parametrize("now", [math.nan, math.inf, -math.inf, "3"])
def test_a_time_that_is_no_number_is_refused_and_ends_no_limit(now: float) -> None:
    table = Config(commands={"come here": Step(drive=0.1, metres=0.2)}).table
    events: list[Event] = []
    drive = Controller([events.append], Safety(motion_time_limit=9), True, table)
    drive.hear(heard("come here", now=1))
    for take_time in (drive.send, drive.zero):
        with pytest.raises(ConfigError):
            take_time(now)
    drive.send(2.9)
    assert drive.velocities == (0.1, 0)
    drive.send(3.0)
    assert events[-1] == Twist(3.0, 0, 0)


@pytest.mark.parametrize("stop", [Controller.stop, Controller.stop_by_hand])
def test_a_stop_at_no_time_stops_all_the_same(stop: Callable[..., None]) -> None:
    drive, events = listening_drive(["go forward"])
    with pytest.raises(ConfigError, match="the time of the run is nan; give seconds"):
        stop(drive, math.nan, "a key")
    drive.send(0.1)
    assert events[-1] == Twist(0.1, 0, 0)
    drive.stop(5.0, "lost")
    drive.hear(heard("go forward", now=4))  # said before
    assert drive.velocities == (0, 0)


@pytest.mark.parametrize("odd", [math.nan, math.inf])
def test_odometry_that_is_no_place_ends_a_motion_by_its_velocity(odd: float) -> None:
    table = Config(commands={"turn round": Step(rotate=0.5, degrees=45)}).table
    drive = Controller([], Safety(), True, table, lambda _: (0.0, 0.0, odd))
    drive.hear(heard("turn round"))
    drive.send(1.5)
    assert drive.velocities == (0, 0.5)
    drive.send(1.6)  # pi / 4 / 0.5 = 1.57
    assert drive.velocities == (0, 0)


@pytest.mark.parametrize("text", ["start speech", "stop speech", "stop", "slow down"])
def test_what_comes_too_late_may_still_end_the_motion_and_switch_the_listening(text: str) -> None:
    drive, events = listening_drive(["go forward", "slow down"])
    drive.hear(heard(text), late=True)
    (utterance,) = [e for e in events if isinstance(e, Utterance) and e.text == text][-1:]
    assert utterance.obeyed is (text != "start speech")  # which would leave it moving
    assert drive.velocities == ((0.05, 0) if text == "start speech" else (0, 0))
    drive.halt()
    drive.hear(heard("start speech"), late=True)
    assert drive.listening


@given(st.lists(st.sampled_from(COMMANDS), max_size=20), st.sampled_from(COMMANDS))
def test_what_comes_too_late_begins_no_motion_and_moves_no_arm(
    spoken: list[str], text: str
) -> None:
    drive, events = listening_drive(spoken)
    before, so_far = drive.velocities, len(events)
    drive.hear(heard(text), late=True)
    assert drive.velocities in (before, (0, 0))
    assert not any(isinstance(event, SelectedObject) for event in events[so_far:])


@given(st.sampled_from(COMMANDS))
def test_while_the_robot_speaks_only_stop_is_obeyed(text: str) -> None:
    drive, events = listening_drive(["go forward"])
    drive.hear(replace(heard(text), ignored="robot_speaking"))
    (utterance,) = events[len(events) - 1 :]
    assert isinstance(utterance, Utterance)
    assert utterance.obeyed is (text == "stop")
    assert drive.velocities == ((0, 0) if text == "stop" else (0.1, 0))


def test_a_key_stops_whatever_drives_the_robot() -> None:
    drive, events = listening_drive(["go forward"])
    drive.stop_by_hand(2.0, "stopped by a key")
    assert drive.velocities == (0, 0)
    assert events[-1] == Warning(2.0, "stopped by a key", good=True, stops=True)


def said(text: str, start: float, decided: float, source: str = "microphone") -> Utterance:
    return Utterance(decided, text, 0.9, True, start, decided - 0.3, source)


@pytest.mark.parametrize("ended", [1.8, 2.1])
def test_what_somebody_began_to_say_before_a_key_was_pressed_moves_nothing(ended: float) -> None:
    drive, events = listening_drive()
    drive.stop_by_hand(2.0, "stopped by a key", 2.0)
    drive.hear(said("go forward", 1.4, ended + 0.3))
    assert drive.velocities == (0, 0)
    (utterance,) = [e for e in events if isinstance(e, Utterance)]
    assert (utterance.obeyed, utterance.ignored) == (False, "too_late")
    drive.hear(said("go forward", 2.0, 2.9))
    assert drive.velocities == (0.1, 0)


@given(st.floats(-10, 0))
def test_what_somebody_began_to_say_before_the_run_is_obeyed(start: float) -> None:
    drive, _ = listening_drive()
    drive.hear(said("go forward", start, 0.9))
    assert drive.velocities == (0.1, 0)


@pytest.mark.parametrize("text", STOPPING)
def test_what_was_begun_before_a_stop_from_elsewhere_and_settled_after_it_moves_nothing(
    text: str,
) -> None:
    drive, _ = listening_drive(["go back"])
    drive.hear(replace(said(text, 2.0, 2.0), source="text"))
    drive.hear(said("go forward", 1.5, 2.4))
    assert drive.velocities == (0, 0)
    drive.hear(said("start speech", 1.6, 2.5))
    drive.hear(said("go forward", 2.01, 3.0))
    assert drive.velocities == (0.1, 0)


def test_a_loss_stops_whatever_drives_the_robot_and_a_return_nothing() -> None:
    drive, events = listening_drive()
    drive.stop(1.0, "it is lost")
    drive.stop(2.0, "it is back", good=True)
    assert [e.stops for e in events if isinstance(e, Warning)] == [True, False]


@given(st.lists(st.sampled_from(COMMANDS), max_size=20))
def test_in_a_rehearsal_all_is_told_and_nothing_moves(spoken: list[str]) -> None:
    drive, events = listening_drive()
    drive.rehearsing = True
    for text in spoken:
        drive.hear(heard(text))
        drive.send(0)
    told = [event for event in events if isinstance(event, Utterance)]
    assert [event.text for event in told] == spoken
    assert all(event.obeyed == (event.text == "stop") for event in told)
    assert all(event.ignored == "rehearsal" for event in told if not event.obeyed)
    assert {type(event) for event in events} <= {Utterance, Twist}
    assert drive.velocities == (0, 0)
    assert drive.listening


def test_a_rehearsal_does_not_keep_stop_from_a_robot_that_moves() -> None:
    drive, _ = listening_drive(["go forward"])
    drive.rehearsing = True
    drive.hear(heard("stop"))
    assert drive.velocities == (0, 0)
