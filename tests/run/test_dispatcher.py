"""Messages to all receivers, and what is refused on the way; with time as an argument."""

from __future__ import annotations

import math
import queue
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import pytest
from programs import PATIENCE

from voz.config import Config, default_commands
from voz.control.controller import ControllerState, Rules
from voz.control.messages import Beat, ControllerMessage, End, Halt, StopMotion
from voz.control.motion import Place
from voz.control.state_machine import State
from voz.control.steps import Step
from voz.errors import ConfigError, RobotError
from voz.events import Event, Notice, Partial, Receiver, SelectedObject, Twist, Utterance
from voz.run.dispatcher import MAX_QUEUED_EVENTS, Dispatcher, QueuedReceiver
from voz.settings import Safety


def heard(text: str, accepted: bool = True, now: float = 0) -> Utterance:
    return Utterance(now, text, 0.9, accepted, now, now, "microphone")


def dispatcher(*receivers: Receiver, config: Config | None = None) -> Dispatcher:
    table = config.table if config else default_commands()
    rules = Rules(table, Safety(motion_time_limit=9))
    return Dispatcher(ControllerState(rules, State(listening=True)), receivers)


def test_everything_reaches_every_receiver_in_order() -> None:
    first: list[Event] = []
    second: list[Event] = []
    controller = dispatcher(first.append, second.append)
    controller.take(heard("point beer"), 0.05)
    controller.take(Beat(), 0.1)
    controller.zero(0.2)
    assert first == second
    assert first[1:] == [SelectedObject(0, 1), Twist(0.1, 0, 0), Twist(0.2, 0, 0)]


@pytest.mark.parametrize("now", [math.nan, math.inf, -math.inf, "3"])
def test_a_time_that_is_no_number_is_refused_and_ends_no_limit(now: float) -> None:
    events: list[Event] = []
    config = Config(commands={"come here": Step(drive=0.1, metres=0.2)})
    controller = dispatcher(events.append, config=config)
    controller.take(heard("come here", now=1), 1)
    for take_time in (partial(controller.take, Beat()), controller.zero):
        with pytest.raises(ConfigError):
            take_time(now)
    controller.take(Beat(), 2.9)
    assert controller.velocities == (0.1, 0)
    controller.take(Beat(), 3.0)
    assert events[-1] == Twist(3.0, 0, 0)


@pytest.mark.parametrize("stop", [StopMotion("a key"), Halt("a key"), Halt("a key", math.nan)])
def test_a_stop_at_no_time_stops_all_the_same(stop: ControllerMessage) -> None:
    events: list[Event] = []
    controller = dispatcher(events.append)
    controller.take(heard("go forward"), 0)
    with pytest.raises(ConfigError, match="the time of the run is nan; give seconds"):
        controller.take(stop, math.nan)
    controller.take(Beat(), 0.1)
    assert events[-1] == Twist(0.1, 0, 0)
    controller.take(StopMotion("lost"), 5.0)
    controller.take(heard("go forward", now=4), 5.0)  # said before
    assert controller.velocities == (0, 0)


def test_a_run_lasts_no_longer_than_a_time_can_be_written() -> None:
    events: list[Event] = []
    controller = dispatcher(events.append)
    controller.take(Beat(), 1e12)
    assert events == [Twist(1e12, 0, 0)]
    with pytest.raises(ConfigError, match="the time of the run is 11"):
        controller.take(Beat(), 1.1e12)


def test_what_one_receiver_raises_keeps_nothing_from_the_others_and_is_raised_then() -> None:
    events: list[Event] = []
    errors = [BrokenPipeError("first"), SystemExit("second")]

    def fail(_: Event) -> None:
        raise errors[min(len(events), 1)]

    controller = dispatcher(fail, events.append, fail)
    with pytest.raises(BrokenPipeError, match="first"):
        controller.zero(1.0)
    assert events == [Twist(1.0, 0, 0)]


def test_in_another_process_than_its_own_it_sends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    events: list[Event] = []
    controller = dispatcher(events.append)
    assert not controller.is_forked
    monkeypatch.setattr("os.getpid", lambda: -1)
    with pytest.raises(RobotError, match="a forked process does not drive"):
        controller.zero(1.0)
    assert events == []


def test_odometry_is_asked_for_the_time_of_what_was_said_and_of_the_beat() -> None:
    asked: list[float] = []

    def odometry(t: float) -> Place | None:
        asked.append(t)
        return None

    controller = dispatcher()
    controller.odometry = odometry
    controller.take(Partial(0.1, "stop", 0.9), 0.15)  # it stands
    controller.take(heard("go back", accepted=False, now=0.2), 0.25)
    controller.take(heard("go back", now=0.3), 0.35)
    controller.take(Partial(0.4, "go back", 0.9), 0.45)
    controller.take(Beat(), 0.5)
    controller.take(StopMotion("lost"), 0.6)
    assert asked == [0.3, 0.4, 0.5]


@pytest.mark.parametrize("message", [heard("stop"), Partial(0, "stop", 0.9), Beat()])
def test_a_mistake_in_the_odometry_stops_the_robot(message: ControllerMessage) -> None:
    def fail(_: float) -> Place | None:
        raise ValueError("no odometry")

    controller = dispatcher()
    controller.take(heard("go forward"), 0)
    controller.odometry = fail
    with pytest.raises(ValueError, match="no odometry"):
        controller.take(message, 0.1)
    assert not controller.moving


class Log:
    """Keeps events; stalls while `flows` is not set, and fails at the event of `fails_at`."""

    def __init__(self, fails_at: float | None = None) -> None:
        self.flows = threading.Event()
        self.flows.set()
        self.begun = threading.Event()
        self.times: list[float] = []
        self.closed_on = ""
        self._fails_at = fails_at

    @contextmanager
    def opening(self) -> Iterator[Receiver]:
        try:
            yield self._write
        finally:
            self.closed_on = threading.current_thread().name

    def _write(self, event: Event) -> None:
        self.begun.set()
        self.flows.wait()
        if event.t == self._fails_at:
            raise ConfigError("log: cannot be written (No space left on device)")
        self.times.append(event.t)


def twist(t: float) -> Twist:
    return Twist(t, 0.1, 0.0)


def test_all_events_are_written_in_order_before_it_is_closed() -> None:
    log = Log()
    with QueuedReceiver("log", log.opening(), pytest.fail) as receive:
        for number in range(200):
            receive(twist(number))
    assert log.times == list(range(200))
    assert log.closed_on == "voz-queued"


def test_who_sends_does_not_wait_and_is_warned_once() -> None:
    log = Log()
    log.flows.clear()
    told: list[Notice | End] = []
    with QueuedReceiver("log", log.opening(), told.append) as receive:
        receive(twist(0))
        assert log.begun.wait(PATIENCE)  # that one is stuck, and the others wait
        for number in range(1, MAX_QUEUED_EVENTS + 3):
            receive(twist(number))
        text = "log: cannot be written fast enough; events are missing"
        assert told == [Notice(MAX_QUEUED_EVENTS + 1, text)]
        log.flows.set()
    assert log.times == list(range(MAX_QUEUED_EVENTS + 1))


def test_what_it_raises_ends_the_run_and_who_sends_goes_on() -> None:
    log = Log(fails_at=0)
    told: queue.SimpleQueue[Notice | End] = queue.SimpleQueue()
    queued = QueuedReceiver("log", log.opening(), told.put)
    receive = queued.__enter__()
    receive(twist(0))
    end = told.get(timeout=PATIENCE)
    assert isinstance(end, End)
    assert "No space left" in str(end.error)
    for number in range(MAX_QUEUED_EVENTS + 3):
        receive(twist(number))
    assert told.empty()
    with pytest.raises(ConfigError, match="No space left"):
        queued.__exit__(None, None, None)


def test_an_error_that_ended_the_run_is_not_hidden_by_another_at_its_end() -> None:
    log = Log(fails_at=0)
    told: queue.SimpleQueue[Notice | End] = queue.SimpleQueue()
    queued = QueuedReceiver("log", log.opening(), told.put)
    queued.__enter__()(twist(0))
    told.get(timeout=PATIENCE)
    queued.__exit__(RuntimeError, RuntimeError(), None)


def test_what_it_raises_last_is_raised_at_the_end() -> None:
    log = Log(fails_at=2)
    queued = QueuedReceiver("log", log.opening(), lambda _: None)
    receive = queued.__enter__()
    receive(twist(1))
    receive(twist(2))
    with pytest.raises(ConfigError, match="No space left"):
        queued.__exit__(None, None, None)
    assert log.times == [1]


def test_what_opening_raises_is_raised_at_once() -> None:
    @contextmanager
    def closed() -> Iterator[Receiver]:
        raise ConfigError("none/log: cannot be written (No such file or directory)")
        yield

    with (
        pytest.raises(ConfigError, match="No such file"),
        QueuedReceiver("log", closed(), pytest.fail),
    ):
        pytest.fail("it is not open")
