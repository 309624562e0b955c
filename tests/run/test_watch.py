"""S5: what is lost stops the robot, and what is back does not set it going."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.control.motion import Motion
from voz.control.state_machine import State
from voz.events import Event, Notice, Utterance
from voz.inbox import Inbox
from voz.run.controller import Controller
from voz.run.session import Session
from voz.run.watch import Flood, Watch
from voz.settings import Safety


def go_forward(t: float, source: str = "text") -> Utterance:
    return Utterance(t, "go forward", 1.0, True, t, t, source)


class Run:
    def __init__(self, *names: str) -> None:
        self.lost: dict[str, str | None] = dict.fromkeys(names)
        self.events: list[Event] = []
        self.controller = Controller([self.events.append], Safety(), listening=True)
        self.watches = [
            Watch(self.controller, lambda name=name: self.lost[name], f"{name} is there")
            for name in names
        ]

    def look(self, t: float) -> tuple[float, float]:
        for watch in self.watches:
            watch.look(t)
        return self.controller.velocities

    @property
    def warnings(self) -> list[str]:
        return [event.text for event in self.events if isinstance(event, Notice)]


def test_a_lost_robot_stops_the_motion_and_is_named_once() -> None:
    run = Run("ros1", "ros2")
    run.controller.hear(go_forward(0))
    assert run.look(0.1) == (0.1, 0)
    run.lost["ros2"] = "the robot ros2 is lost (nobody listens)"
    assert run.look(0.2) == run.look(0.3) == (0, 0)
    assert run.warnings == ["the robot ros2 is lost (nobody listens): the robot stops"]


def test_what_was_said_while_it_was_lost_does_not_move_it_when_it_is_back() -> None:
    run = Run("ros1")
    run.lost["ros1"] = "gone"
    run.look(0)
    run.controller.hear(go_forward(0.1))
    run.lost["ros1"] = None
    assert run.look(0.2) == (0, 0)
    assert run.warnings[-1] == "ros1 is there; the robot waits for a command"
    assert [event.good for event in run.events if isinstance(event, Notice)] == [False, True]
    run.controller.hear(go_forward(0.3))
    assert run.look(0.4) == (0.1, 0)


def test_the_second_of_two_that_are_lost_stops_it_too() -> None:
    run = Run("ros1", "ros2")
    run.lost["ros1"] = "gone"
    run.look(0)
    run.controller.hear(go_forward(0.1))  # for the other one
    run.lost["ros2"] = "gone too"
    assert run.look(0.2) == (0, 0)
    assert run.warnings == ["gone: the robot stops", "gone too: the robot stops"]


@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), max_size=50))
def test_motion_ends_with_every_change_and_goes_on_without_one(
    steps: list[tuple[bool, bool, bool]],
) -> None:
    run = Run("a", "b")
    before = (False, False)
    for t, (a, b, command) in enumerate(steps):
        if command:
            run.controller.hear(go_forward(t))
        moving = run.controller.velocities
        run.lost = {"a": "a" if a else None, "b": "b" if b else None}
        assert run.look(t) == ((0, 0) if (a, b) != before else moving)
        before = (a, b)


@pytest.mark.parametrize("moved_before", [False, True])
def test_while_it_is_lost_what_moves_the_robot_all_the_same_is_stopped_again(
    moved_before: bool,
) -> None:
    events: list[Event] = []
    controller = Controller([events.append], Safety(), listening=True)
    # Nothing of it comes too late, as if the loss were noted nowhere else.
    watch = Watch(controller, lambda: "gone", "back", "page", mark_late=lambda *_: None)
    if moved_before:
        controller.hear(go_forward(0, "page"))
    watch.look(0.1)
    controller.hear(go_forward(0.15, "text"))
    controller.hear(go_forward(0.15, "page"))
    assert controller.moving
    watch.look(0.2)
    assert not controller.moving
    controller.hear(go_forward(0.25, "text"))  # from elsewhere: it goes on
    watch.look(0.3)
    assert controller.moving
    assert [event.text for event in events if isinstance(event, Notice)] == [
        "gone: the robot stops"
    ] * 2


def test_while_it_is_lost_what_moves_the_robot_without_a_command_is_stopped_again() -> None:
    controller = Controller([], Safety(), listening=True)
    watch = Watch(controller, lambda: "gone", "back")
    watch.look(0.1)
    controller._state = State(listening=True, motion=Motion(linear=100))  # as by a fault in voz
    watch.look(0.2)
    assert not controller.moving


def test_a_source_with_two_losses_is_heard_again_when_both_are_over() -> None:
    lost = {"microphone": True, "page": True}
    clock: Any = None
    session = Session(clock, Controller([], Safety(), listening=True))
    session.watch({"page": lambda: "gone" if lost["page"] else None}, "page", "browser")
    session.watch_input(Hearing(lost))

    def moves(t: float) -> bool:
        for watch in session._watches:
            watch.look(t)
        session.controller.hear(go_forward(t, "browser"))
        return session.controller.moving

    assert not moves(1)
    lost["page"] = False
    assert not moves(2)
    lost["microphone"] = False
    assert moves(3)


class Hearing:
    """A browser as a microphone."""

    source = "browser"

    def __init__(self, lost: dict[str, bool]) -> None:
        self._lost = lost

    def trouble(self, moving: bool) -> str | None:
        return "no sound comes" if self._lost["microphone"] else None


def flood_lines(dropped: dict[float, int]) -> list[tuple[float, str]]:
    """What is told of a flood: by the time of each look (s), what was dropped so far."""
    run, inbox = Run(), Inbox(set())
    flood = Flood(run.controller, inbox)
    for t, inbox.dropped in dropped.items():
        flood.look(t)
    return [(event.t, event.text) for event in run.events if isinstance(event, Notice)]


def test_a_flood_is_one_line_when_it_is_over() -> None:
    looks = {20 + t / 10: min(max(t - 3, 0), 4) * 100 for t in range(100)}
    assert flood_lines(looks) == [(20.8, "400 messages came too fast and were dropped")]


@pytest.mark.parametrize("first", [0, 1])
def test_a_flood_without_an_end_is_a_line_now_and_then(first: int) -> None:
    lines = flood_lines({t / 10: t * 100 for t in range(first, 160)})
    assert [t for t, _ in lines] == [5.0, 10.0, 15.0]
    assert lines[1][1] == "5000 messages came too fast and were dropped"
