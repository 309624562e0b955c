"""The beat of 10 Hz, and what interrupts it; in a time of its own, so that nothing is noisy."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.control.messages import End, Halt, Message
from voz.events import Event, Notice, Partial, ProgramEnded, Twist, Utterance
from voz.inbox import MAX_QUEUED_MESSAGES
from voz.run.controller import Controller
from voz.run.session import MAX_BEAT_GAP, Session
from voz.run.spec import RunSpec

GONE = "the microphone is gone"


class Room:
    """A clock whose waiting lets the time pass, what happens, and a robot that notes what it gets.

    Attributes:
        happens: what is heard or typed, and when.
        lost: from when to when nothing is heard.
        stalls: how long the loop stands still after a time, s.
        begin: is given the session before it begins.
    """

    def __init__(
        self,
        until: float,
        happens: list[tuple[float, Message]] | None = None,
        lost: tuple[float, float] = (0, 0),
        stalls: dict[float, float] | None = None,
        begin: Callable[[Session], None] = lambda _: None,
    ) -> None:
        self._now = 0.0
        self._happens = [*(happens or []), (until, End())]
        self._lost = lost
        self._stalls = stalls or {}
        self.sent: list[tuple[float, Event]] = []
        self.source = "microphone"
        spec = RunSpec(
            controller=Controller([self._receive], listening=True),
            clock=lambda _: self,
            in_real_time=False,
        )
        session = Session(spec)
        begin(session)
        session.watch_input(self)
        session.startup(ExitStack())
        session.main_loop()

    def now(self) -> float:
        return self._now

    def next_before(self, until: float) -> Message | None:
        when, message = self._happens[0]
        if when < until or self._now > when:
            self._happens.pop(0)
            self._now = max(self._now, when)
            return message
        self._now = max(self._now, until)
        return None

    def skip(self, seconds: float) -> None:
        pass

    def trouble(self, moving: bool) -> str | None:
        return GONE if self._lost[0] <= self._now < self._lost[1] else None

    def _receive(self, event: Event) -> None:
        self.sent.append((self._now, event))
        for when in [when for when in self._stalls if when <= self._now]:
            self._now += self._stalls.pop(when)

    @property
    def twists(self) -> list[tuple[float, float]]:
        twists = [(when, event) for when, event in self.sent if isinstance(event, Twist)]
        return [(round(when, 3), event.linear) for when, event in twists]

    @property
    def warnings(self) -> list[tuple[float, str]]:
        warnings = [(when, event) for when, event in self.sent if isinstance(event, Notice)]
        return [(round(when, 3), event.text) for when, event in warnings]


def heard(text: str, end: float = 9, source: str = "microphone") -> Utterance:
    return Utterance(end, text, 0.9, True, end, end, source)


def test_the_beat_is_10_hz() -> None:
    assert Room(1.05).twists == [(round(n / 10, 3), 0) for n in range(11)]


def test_a_changed_velocity_goes_out_at_once_and_the_beat_goes_on() -> None:
    room = Room(0.45, [(0.234, heard("go forward"))])
    assert room.twists == [(0, 0), (0.1, 0), (0.2, 0), (0.234, 0.1), (0.3, 0.1), (0.4, 0.1)]


@pytest.mark.parametrize("message", [Halt(), heard("stop"), Partial(0, "stop", 0.9)])
def test_what_stops_goes_out_at_once(message: Message) -> None:
    room = Room(0.35, [(0.05, heard("go back")), (0.25, message)])
    assert (0.25, 0) in room.twists


def test_it_goes_out_at_once_later_in_a_run_too() -> None:
    room = Room(1.35, [(1.234, heard("go forward"))])
    assert room.twists[-2:] == [(1.234, 0.1), (1.3, 0.1)]


def test_what_changes_no_velocity_waits_for_the_beat() -> None:
    room = Room(0.35, [(0.15, heard("point beer")), (0.25, heard("stop"))])
    assert [when for when, _ in room.twists] == [0, 0.1, 0.2, 0.3]


def test_beats_that_are_missed_are_left_out_and_come_in_no_burst() -> None:
    room = Room(1.25, stalls={0.3: 0.43})
    assert [when for when, _ in room.twists] == [0, 0.1, 0.2, 0.3, 0.73, 0.8, 0.9, 1, 1.1, 1.2]
    assert room.warnings == []


def test_after_a_pause_longer_than_a_base_waits_the_motion_is_over() -> None:
    room = Room(2, [(0.05, heard("go forward"))], stalls={0.3: 1.5})
    assert room.twists[:6] == [(0, 0), (0.05, 0.1), (0.1, 0.1), (0.2, 0.1), (0.3, 0.1), (1.8, 0)]
    assert room.warnings == [(1.8, "control loop stalled for 1.5 s: the robot stops")]


@pytest.mark.parametrize(("pause", "over"), [(0.5, False), (0.6, True)])
def test_a_pause_is_too_long_after_half_a_second(pause: float, over: bool) -> None:
    room = Room(
        1.35, [(0.05, heard("go forward")), (0.7, heard("go back", 0.7))], stalls={0.5: pause}
    )
    assert bool(room.warnings) is over
    sent = [twist for twist in room.twists if twist[0] >= 0.7]
    assert sent[:2] == ([(1.1, 0), (1.2, 0)] if over else [(1.0, -0.1), (1.0, -0.1)])


def test_what_was_said_before_or_in_a_pause_does_not_begin_a_new_motion() -> None:
    said = [(1.8, heard("go back", end=0.9)), (1.81, heard("go forward", end=0.2))]
    room = Room(2.5, said, stalls={0.3: 1.5})
    assert not any(linear for _, linear in room.twists)
    late = [event for _, event in room.sent if isinstance(event, Utterance)]
    assert [(event.obeyed, event.ignored) for event in late] == [(False, "too_late")] * 2


@given(st.floats(MAX_BEAT_GAP + 0.11, 20), st.floats(0, 3))
def test_no_pause_is_overlooked_whenever_it_comes(pause: float, begin: float) -> None:
    room = Room(24, [(0.01, heard("go forward", 0.01))], stalls={begin: pause})
    assert not any(linear for when, linear in room.twists if when > begin + pause)


@given(st.dictionaries(st.floats(0, 3), st.floats(0, 0.7), max_size=5))
def test_whatever_stalls_there_is_one_beat_in_a_cycle_at_most(stalls: dict[float, float]) -> None:
    until = 4 + sum(stalls.values())
    times = [when for when, event in Room(until, stalls=stalls).sent if isinstance(event, Twist)]
    cycles = [int(when * 10) for when in times]
    assert len(cycles) == len(set(cycles))
    assert times[-1] > until - 0.11  # and it goes on


def test_s5_where_hearing_is_lost_the_robot_stops_once_and_is_told_why() -> None:
    room = Room(1.55, [(0.05, heard("go forward"))], lost=(0.42, 1.13))
    assert room.warnings == [
        (0.5, f"{GONE}: the robot stops"),
        (1.2, "listening again; the robot waits for a command"),
    ]
    moving = [when for when, linear in room.twists if linear]
    assert moving == [0.05, 0.1, 0.2, 0.3, 0.4]


def test_typed_commands_move_the_robot_also_while_nothing_is_heard() -> None:
    room = Room(1, [(0.45, heard("go back", source="text"))], lost=(0.2, 3))
    assert room.twists[-1] == (1, -0.1)
    assert len(room.warnings) == 1


def test_s5_of_what_is_lost_the_microphone_is_told_first() -> None:
    room = Room(
        0.35, lost=(0.2, 9), begin=lambda session: session.watch("wheels", lambda: "no wheels")
    )
    assert [text for _, text in room.warnings] == [
        "no wheels: the robot stops",
        f"{GONE}: the robot stops",
    ]
    room = Room(0.05, lost=(0, 9), begin=lambda session: session.watch("wheels", lambda: "none"))
    assert [text for _, text in room.warnings] == [
        f"{GONE}: the robot stops",
        "none: the robot stops",
    ]


def test_messages_that_are_dropped_are_told() -> None:
    def flood(session: Session) -> None:
        for _ in range(MAX_QUEUED_MESSAGES + 2):
            session.inbox.put(Notice(0, "much"))

    texts = [text for _, text in Room(6, begin=flood).warnings]
    assert texts == ["2 messages came too fast and were dropped"]


def test_what_nobody_watches_has_an_end() -> None:
    go = [(0.05, heard("go forward", 0.05, "a script"))]
    room = Room(7, go, begin=lambda session: session.add_unwatched("a script"))
    assert room.twists[-1] == (7, 0)


class Ended:
    """A clock whose run is over when it begins."""

    def now(self) -> float:
        return 0.0

    def next_before(self, until: float) -> Message | None:
        return End()

    def skip(self, seconds: float) -> None:
        pass


class Speaker:
    """Finds something wrong when it is closed."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def close(self) -> None:
        self._session.warn("the voice is gone")


def reports(*, in_real_time: bool) -> tuple[list[Event], list[Message]]:
    """What receivers get of a run in which a part reports and warns, and what its inbox has."""
    events: list[Event] = []
    ended = ProgramEnded(0.0, "wave", "")

    @contextmanager
    def part(session: Session) -> Iterator[None]:
        speaker: Any = Speaker(session)
        session.speaker = speaker
        session.receivers.append(events.append)
        session.report(ended)
        session.warn("something is wrong")
        yield

    controller = Controller([])
    spec = RunSpec(
        controller=controller, clock=lambda _: Ended(), in_real_time=in_real_time, parts=[part]
    )
    session = Session(spec)
    session.run()
    assert controller.receivers == []
    messages = []
    while message := session.inbox.take(0):
        messages.append(message)
    return events, messages


def test_in_real_time_parts_report_by_the_inbox() -> None:
    ended, wrong = ProgramEnded(0.0, "wave", ""), Notice(0.0, "something is wrong")
    assert reports(in_real_time=True) == ([Twist(0, 0, 0)], [ended, wrong])


def test_without_a_clock_they_report_at_once_and_warnings_come_last() -> None:
    ended, wrong = ProgramEnded(0.0, "wave", ""), Notice(0.0, "something is wrong")
    events, messages = reports(in_real_time=False)
    assert events == [ended, wrong, Notice(0.0, "the voice is gone"), Twist(0, 0, 0)]
    assert messages == []


@pytest.mark.parametrize("in_real_time", [True, False])
def test_a_signal_ends_a_run_in_real_time_by_the_inbox(
    in_real_time: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    wakes: list[Callable[[], None]] = []

    @contextmanager
    def defer(wake: Callable[[], None]) -> Iterator[None]:
        wakes.append(wake)
        yield

    monkeypatch.setattr("voz.run.session.defer_signals", defer)
    spec = RunSpec(controller=Controller([]), clock=lambda _: Ended(), in_real_time=in_real_time)
    session = Session(spec)
    session.run()
    for wake in wakes:
        wake()
    assert session.inbox.take(0) == (End() if in_real_time else None)
