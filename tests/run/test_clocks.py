"""Recordings and lines at their own pace: the same events, by the clock."""

from __future__ import annotations

import itertools
import queue
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from driving import speak, type_lines
from programs import PATIENCE, wait_until
from recordings import FIXTURES, GO_BACK

from voz.api.recognizer import Recognizer
from voz.control.messages import Message
from voz.errors import AudioError
from voz.events import Event, Notice, Twist, Utterance
from voz.inbox import Inbox
from voz.run import clocks
from voz.run.clocks import BEATS_PER_SECOND, HANDOVER_LEAD, elapsed

LINES = ["start speech", "go forward", "-", "turn left", "stop"]


class OwnTime:
    """A time that goes on only when all threads of a run wait for it, at once to what comes next.

    So it stands still while a thread computes, or a busy machine does not let it.
    """

    def __init__(self, threads: Callable[[], list[threading.Thread]]) -> None:
        self.now = 0.0
        self._threads = threads
        self._queue: WatchedQueue | None = None
        self._awaited: threading.Event | None = None
        self._sleepers: list[float] = []
        self._changed = threading.Condition()

    def elapsed(self) -> float:
        return self.now

    def queue(self, size: int) -> WatchedQueue:
        """What the run reads ahead."""
        self._queue = WatchedQueue(size)
        return self._queue

    def sleep(self, ended: threading.Event, seconds: float) -> bool:
        """Wait, on the thread that hands over, until the run ends."""
        with self._changed:  # else time may go on before it is there, and back to it later
            until = self.now + max(seconds, 1e-6)
            self._sleepers.append(until)
            while not self._changed.wait_for(lambda: self.now >= until, 0.1):
                if ended.is_set():
                    break
        return ended.is_set()

    def wait(self, event: threading.Event) -> None:
        """Wait for something that happens in time, on the thread that reads ahead."""
        self._awaited = event
        assert event.wait(PATIENCE)

    def stall(self, seconds: float) -> None:
        """Let time go on while the thread that drives does nothing."""
        with self._changed:
            self._go_on(self.now + seconds)

    def take(self, inbox: Inbox, timeout: float) -> Message | None:
        """Take a message when it comes, on the thread that drives."""
        until = self.now + timeout
        wait_until(self._all_wait)
        while (taken := take_at_once(inbox, 0.0)) is None and self.now < until:
            with self._changed:
                self._go_on(min([until, *self._sleepers]))
            wait_until(self._all_wait)
        return taken

    def _go_on(self, until: float) -> None:
        self.now = until
        self._sleepers = [sleeper for sleeper in self._sleepers if sleeper > until]
        self._changed.notify_all()

    def _all_wait(self) -> bool:
        """Whether no thread will do anything before time goes on."""
        if self._sleepers or "voz-pace" not in {thread.name for thread in self._threads()}:
            return True
        awaits = self._awaited is not None and not self._awaited.is_set()
        return awaits and self._queue is not None and self._queue.is_awaited()


class WatchedQueue(queue.Queue[Any]):
    """A queue that knows whether somebody waits for more."""

    _awaited = False

    def get(self, *arguments: Any) -> Any:
        with self.mutex:
            self._awaited = True
        return super().get(*arguments)

    def _get(self) -> Any:
        self._awaited = False
        return super()._get()

    def is_awaited(self) -> bool:
        with self.mutex:
            return self._awaited and not self._qsize()


take_at_once = Inbox.take


@pytest.fixture(autouse=True)
def own_time(
    begun: Callable[[], list[threading.Thread]], monkeypatch: pytest.MonkeyPatch
) -> OwnTime:
    """The time of these runs."""
    own_time = OwnTime(begun)
    monkeypatch.setattr(clocks, "elapsed", own_time.elapsed)
    monkeypatch.setattr(clocks, "wait", own_time.sleep)
    monkeypatch.setattr(clocks, "queue", SimpleNamespace(Queue=own_time.queue))
    monkeypatch.setattr(Inbox, "take", lambda inbox, timeout: own_time.take(inbox, timeout))
    return own_time


class Clocked:
    """The events of a run by the clock, and when each came."""

    def __init__(self, own_time: OwnTime) -> None:
        self.events: list[Event] = []
        self.times: list[float] = []
        self._own_time = own_time

    def receive(self, event: Event) -> None:
        self.events.append(event)
        self.times.append(self._own_time.now)


def test_typed_lines_give_the_same_events_each_in_its_tenth_of_a_second(own_time: OwnTime) -> None:
    run, twin = Clocked(own_time), Clocked(own_time)
    type_lines(LINES, run.receive, paced=True)
    type_lines(LINES, twin.receive)
    assert run.events == twin.events
    *beats, _ = [t for t, e in zip(run.times, run.events, strict=True) if isinstance(e, Twist)]
    # The last is the zero that ends the run, and that comes at once.
    assert beats == pytest.approx([beats[0] + n / 10 for n in range(len(beats))])


@pytest.mark.slow
def test_recordings_give_the_same_events(recognizer: Recognizer, own_time: OwnTime) -> None:
    paths = [FIXTURES / "commands" / "festival_slt__start_speech.flac", GO_BACK, Path("none.wav")]

    def spoken(paced: bool) -> tuple[list[Event], list[str]]:
        run = Clocked(own_time)
        errors = speak(recognizer, paths, run.receive, paced=paced)
        return run.events, errors

    (events, errors), (expected, other_errors) = spoken(True), spoken(False)
    pairs = itertools.zip_longest(events, expected)
    assert [(event, other) for event, other in pairs if event != other][:3] == []
    assert errors == other_errors


@pytest.mark.slow
def test_an_utterance_takes_effect_at_its_time(recognizer: Recognizer, own_time: OwnTime) -> None:
    run = Clocked(own_time)
    speak(recognizer, [GO_BACK], run.receive, paced=True)
    came = list(zip(run.events, run.times, strict=True))
    begun = next(time for event, time in came if event == Twist(0.0, 0.0, 0.0))
    ((heard, time),) = [(event, time) for event, time in came if isinstance(event, Utterance)]
    assert heard.t - HANDOVER_LEAD <= time - begun + 1e-6 <= heard.t + 1 / BEATS_PER_SECOND


def test_the_beat_goes_on_while_no_line_comes(own_time: OwnTime) -> None:
    more = threading.Event()

    def slowly() -> Iterator[str]:
        yield "start speech"
        yield "go forward"
        own_time.wait(more)
        yield "stop"

    events: list[Event] = []

    def receive(event: Event) -> None:
        events.append(event)
        if sum(isinstance(e, Twist) and e.linear > 0 for e in events) == 5:
            more.set()

    type_lines(slowly(), receive, paced=True)
    times = [event.t for event in events if isinstance(event, Twist)]
    assert times == [n / 10 for n in range(len(times))]
    assert [e.text for e in events if isinstance(e, Utterance)][-1] == "stop"


def test_what_goes_wrong_while_reading_ahead_ends_the_run() -> None:
    def broken() -> Iterator[str]:
        yield "start speech"
        raise AudioError("the disk is gone")

    events: list[Event] = []
    with pytest.raises(AudioError, match="the disk is gone"):
        type_lines(broken(), events.append, paced=True)
    assert events[-1] == Twist(0.1, 0, 0)


def test_a_run_that_ends_before_its_source_leaves_no_thread(
    begun: Callable[[], list[threading.Thread]],
) -> None:
    def receive(event: Event) -> None:
        if isinstance(event, Twist) and event.linear:
            raise OSError("the robot is gone")

    with pytest.raises(OSError, match="the robot is gone"):
        type_lines(["start speech", "go forward", *"-" * 1000], receive, paced=True)
    wait_until(lambda: not begun())


def test_a_pause_ends_the_motion_and_what_follows_comes_at_its_own_pace(own_time: OwnTime) -> None:
    run = Clocked(own_time)
    paused = False

    def receive(event: Event) -> None:
        nonlocal paused
        run.receive(event)
        if event == Twist(0.3, 0.1, 0) and not paused:
            paused = True
            own_time.stall(1.1)  # as if the process were suspended

    lines = ["start speech", "go forward", *"-----", "go back", "-"]
    type_lines(lines, receive, paced=True)
    twists = [event for event in run.events if isinstance(event, Twist)]
    assert [event.linear for event in twists] == [0, 0.1, 0.1, 0.1, 0, 0, 0, -0.1, -0.1, 0]
    (warning,) = [event.text for event in run.events if isinstance(event, Notice)]
    assert warning.startswith("control loop stalled for 1.1 s")


def test_time_goes_on_while_the_computer_is_suspended() -> None:
    # A laptop cannot be shut here; the clock that knows of it is to be the one that is asked.
    assert elapsed() == pytest.approx(time.clock_gettime(time.CLOCK_BOOTTIME), abs=1)
