"""What writes events down on a thread of its own, and what becomes of it if it cannot."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from programs import PATIENCE

from voz.control.messages import End
from voz.errors import ConfigError
from voz.events import Event, Notice, Receiver, Twist
from voz.run.queued import MAX_QUEUED_EVENTS, QueuedReceiver


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
