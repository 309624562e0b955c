from __future__ import annotations

from collections.abc import Sequence

import pytest
from driving import COMMANDS, speak, type_lines
from hypothesis import given, settings
from hypothesis import strategies as st
from recordings import Recording

from voz.api.recognizer import Recognizer
from voz.events import Event, Notice, Reply, SelectedObject, Twist, Utterance
from voz.robot.simulation.simulator import SimulatedRobot, Trip
from voz.robot.simulation.world import WorldState, joints_pointing_at
from voz.settings import Simulator

typed = st.lists(st.sampled_from([*COMMANDS, *["-"] * 30, "xyz"]), max_size=150)


def events_of(lines: Sequence[str]) -> list[Event]:
    events: list[Event] = []
    type_lines(lines, events.append)
    return events


def driven(events: Sequence[Event], room: Simulator | None = None) -> tuple[Trip, list[Notice]]:
    warnings: list[Notice] = []
    robot = SimulatedRobot(room or Simulator(), warnings.append)
    for event in events:
        robot.receive(event)
    robot.come_to_rest()
    return robot.trip(), warnings


def held(linear: float, angular: float, since: float, until: float) -> list[Event]:
    """A velocity sent every 0.1 s."""
    return [Twist(n / 10, linear, angular) for n in range(round(since * 10), round(until * 10))]


def test_it_drives_as_far_as_it_is_told() -> None:
    events = events_of(["start speech", "go forward", *["-"] * 99, "stop", "-"])
    (trip, warnings) = driven(events)
    first, last = trip.states[0], trip.states[-1]
    assert last.pose.x - first.pose.x == pytest.approx(1.0, abs=0.001)
    assert last.pose.y == first.pose.y
    assert warnings == []


@given(typed)
@settings(max_examples=30)
def test_the_same_events_give_the_same_way_and_end_at_rest(lines: list[str]) -> None:
    events = events_of(["start speech", *lines])
    first, again = driven(events), driven(events)
    assert first == again
    assert (first[0].states[-1].linear, first[0].states[-1].angular) == (0.0, 0.0)


@given(typed, st.lists(st.floats(0, 3), max_size=30))
@settings(max_examples=30)
def test_to_look_ahead_changes_nothing(lines: list[str], ahead: list[float]) -> None:
    events = events_of(["start speech", *lines])
    robot = SimulatedRobot(Simulator())
    for number, event in enumerate(events):
        robot.receive(event)
        if number < len(ahead):
            robot.state_at(event.t + ahead[number])
    robot.come_to_rest()
    assert robot.trip() == driven(events)[0]


def test_what_it_sees_ahead_is_what_comes() -> None:
    robot = SimulatedRobot(Simulator())
    for event in held(0.2, 0.3, 0.0, 1.0):
        robot.receive(event)
    ahead = robot.state_at(1.2)
    robot.receive(Reply(1.2, "bep bep"))
    assert robot.state_at(1.2) == ahead
    assert robot.state_at(0.3) == ahead  # the past is over


def test_without_a_publisher_it_never_moves_on() -> None:
    robot = SimulatedRobot(Simulator())
    for event in held(0.3, 0.0, 0.0, 1.0):
        robot.receive(event)
    stopped = robot.state_at(3.0)
    assert (stopped.linear, stopped.angular) == (0.0, 0.0)
    much_later = robot.state_at(1e6)
    assert much_later.pose == stopped.pose
    assert much_later.t == 1e6


def test_a_long_silence_takes_no_time() -> None:
    begins = (0.0, 1e6, 1e9)
    robot = SimulatedRobot(Simulator())
    for begin in begins:
        robot.receive(Twist(begin, 0.2, 0.0))
    robot.come_to_rest()
    first, last = (trip.states[-1] for trip in (driven(held(0.2, 0, 0, 0.1))[0], robot.trip()))
    assert last.t == pytest.approx(1e9 + first.t, abs=0.1)
    begun = Simulator().start[0]
    assert last.pose.x - begun == pytest.approx(3 * (first.pose.x - begun), abs=0.005)


def test_each_collision_is_told_once() -> None:
    events = [
        *held(0.5, 0.0, 0.0, 10.0),  # into the wall, and on
        *held(-0.2, 0.0, 10.0, 12.0),
        *held(0.5, 0.0, 12.0, 15.0),  # and once more
    ]
    trip, warnings = driven(events)
    assert [w.text for w in warnings] == [
        "the robot hit a wall at x 2.43 m, y 0.60 m and stopped: drive it away or rotate it"
    ] * 2
    assert [(mark.t, mark.text) for mark in trip.collisions] == [(w.t, "a wall") for w in warnings]
    assert 3 < warnings[0].t < 5
    assert 12 < warnings[1].t < 15


def test_commands_are_kept_with_their_places_and_what_is_refused_is_not() -> None:
    events = [
        *held(0.2, 0.0, 0.0, 2.0),
        Utterance(1.95, "speed up", 0.9, True, 1.0, 1.9, "a.wav", obeyed=True),
        Utterance(1.96, "go back", 0.1, False, 1.0, 1.9, "a.wav", "part_of_a_command"),
        Utterance(1.96, "go back", 0.9, True, 1.0, 1.9, "a.wav", ignored="not_listening"),
        Notice(1.97, "no loudspeaker"),
    ]
    trip, _ = driven(events)
    (said,) = trip.said
    assert (said.t, said.text) == (1.95, "speed up")
    assert 0.3 < said.x - trip.states[0].pose.x < 0.4


def test_the_selected_object_is_pointed_at_and_the_arm_is_folded_again() -> None:
    trip, _ = driven([SelectedObject(0.5, 2), *held(0.0, 0.0, 0.5, 4.0), SelectedObject(4.0, 100)])

    def last_before(t: float) -> WorldState:
        return [state for state in trip.states if state.t < t][-1]

    assert last_before(4.0).arm == joints_pointing_at(
        trip.states[0].pose, (*Simulator().cocacola, 0.7)
    )
    assert trip.states[-1].arm == trip.states[0].arm
    assert trip.states[-1].selected == 100


def test_a_robot_that_stands_still_takes_no_memory() -> None:
    trip, _ = driven(held(0.0, 0.0, 0.0, 1000.0))
    assert len(trip.states) < 3


@pytest.mark.slow
def test_a_spoken_session_drives_it(session: Recording, recognizer: Recognizer) -> None:
    warnings: list[Notice] = []
    robot = SimulatedRobot(Simulator(), warnings.append)
    speak(recognizer, [session.path], robot.receive)
    robot.come_to_rest()
    trip = robot.trip()
    assert [mark.text for mark in trip.said] == [
        *("start speech", "go forward", "speed up", "turn left", "stop", "rotate right"),
        *("speed up", "stop", "point beer", "fold arm", "stop speech"),
    ]
    assert warnings == []
    begun, ended = trip.states[0].pose, trip.states[-1].pose
    assert 0.7 < ended.x - begun.x < 0.9  # about 2 s at 0.1 m/s, and 4 s at 0.15 m/s
    assert 0.0 < ended.y - begun.y < 0.1  # turned left for 1.6 s
    assert -0.5 < ended.heading < -0.1  # and then further to the right
