"""Recordings and lines at their own pace: the same events, by the clock."""

from __future__ import annotations

import itertools
import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from driving import speak, type_lines
from recordings import FIXTURES, GO_BACK

from voz.errors import AudioError
from voz.events import Event, Twist, Utterance, Warning
from voz.inbox import Inbox, TakenMessage
from voz.recognition.recognizer import Recognizer
from voz.run import clocks
from voz.run.clocks import elapsed

LINES = ["start speech", "go forward", "-", "turn left", "stop"]


TICK = 0.005
"""So often this file's time goes on, s."""

AT_MOST = 0.02
"""And by no more than this, s: what is more is a machine that held up all of us."""


class SteadyTime:
    """A time that goes as fast as the real one, but stands still while the machine does."""

    def __init__(self) -> None:
        self._now = 0.0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._work)

    def __enter__(self) -> SteadyTime:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def now(self) -> float:
        return self._now

    def sleep(self, seconds: float) -> None:
        until = self._now + seconds
        while self._now < until:
            time.sleep(TICK)

    def _work(self) -> None:
        before = time.monotonic()
        while not self._over.wait(TICK):
            now = time.monotonic()
            self._now += min(now - before, AT_MOST)
            before = now


@pytest.fixture(autouse=True)
def steady(monkeypatch: pytest.MonkeyPatch) -> Iterator[SteadyTime]:
    """The time of these runs; on one processor, so that a processor held up holds it up too."""
    take = Inbox.take
    processors = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(processors)})  # of this thread, and of those that it starts
    with SteadyTime() as steady:

        def take_steadily(inbox: Inbox, timeout: float) -> TakenMessage | None:
            until = steady.now() + timeout
            while (taken := take(inbox, TICK)) is None and steady.now() < until:
                pass
            return taken

        monkeypatch.setattr(clocks, "elapsed", steady.now)
        monkeypatch.setattr(Inbox, "take", take_steadily)
        yield steady
    os.sched_setaffinity(0, processors)


class Clocked:
    """The events of a run by the clock, and when each came."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.times: list[float] = []

    def receive(self, event: Event) -> None:
        self.events.append(event)
        self.times.append(time.monotonic())


@pytest.mark.slow
def test_typed_lines_give_the_same_events_each_in_its_tenth_of_a_second() -> None:
    run, twin = Clocked(), Clocked()
    type_lines(LINES, run.receive, paced=True)
    type_lines(LINES, twin.receive)
    assert run.events == twin.events
    beats = [t for t, e in zip(run.times, run.events, strict=True) if isinstance(e, Twist)]
    begun = beats[0]
    # The last is the zero that ends the run, and that comes at once.
    assert all(t - begun > n / 10 - 0.05 for n, t in enumerate(beats[:-1]))


@pytest.mark.slow
def test_recordings_give_the_same_events(recognizer: Recognizer) -> None:
    paths = [FIXTURES / "commands" / "festival_slt__start_speech.flac", GO_BACK, Path("none.wav")]

    def spoken(paced: bool) -> tuple[list[Event], list[str]]:
        run = Clocked()
        errors = speak(recognizer, paths, run.receive, paced=paced)
        return run.events, errors

    assert spoken(True) == spoken(False)


@pytest.mark.slow
def test_an_utterance_takes_effect_at_its_time(recognizer: Recognizer) -> None:
    run = Clocked()
    speak(recognizer, [GO_BACK], run.receive, paced=True)
    came = list(zip(run.events, run.times, strict=True))
    begun = next(time for event, time in came if event == Twist(0.0, 0.0, 0.0))
    ((heard, time),) = [(event, time) for event, time in came if isinstance(event, Utterance)]
    assert time - begun > heard.t - 0.05


def test_the_beat_goes_on_while_no_line_comes() -> None:
    more = threading.Event()

    def slowly() -> Iterator[str]:
        yield "start speech"
        yield "go forward"
        more.wait(30)
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


def test_s5_a_robot_that_is_lost_stops_the_run_and_is_named() -> None:
    events: list[Event] = []
    moved = 0

    def lost() -> str | None:
        nonlocal moved
        moved += any(isinstance(event, Twist) and event.linear for event in events)
        return "the robot x is lost (gone)" if 2 <= moved < 4 else None

    lines = ["start speech", "go forward", *"------"]
    type_lines(lines, events.append, paced=True, x=lost)
    kept = [event for event in events if isinstance(event, Twist | Warning)]
    spells = [list(spell) for _, spell in itertools.groupby(kept, type)]
    assert [e.linear for e in spells[0]] == [0, 0.1, 0.1]
    assert [e.text for e in spells[1]] == ["the robot x is lost (gone): the robot stops"]
    assert [e.text for e in spells[3]] == ["x is there; the robot waits for a command"]
    assert not any(e.linear for e in [*spells[2], *spells[4]])


@pytest.mark.slow
def test_a_pause_ends_the_motion_and_what_follows_comes_at_its_own_pace(
    steady: SteadyTime,
) -> None:
    run = Clocked()
    paused = False

    def receive(event: Event) -> None:
        nonlocal paused
        run.receive(event)
        if event == Twist(0.3, 0.1, 0) and not paused:
            paused = True
            steady.sleep(1)  # as if the process were suspended

    lines = ["start speech", "go forward", *"-----", "go back", "-"]
    type_lines(lines, receive, paced=True)
    twists = [event for event in run.events if isinstance(event, Twist)]
    assert [event.linear for event in twists] == [0, 0.1, 0.1, 0.1, 0, 0, 0, -0.1, -0.1, 0]
    (warning,) = [event.text for event in run.events if isinstance(event, Warning)]
    assert warning.startswith("control loop stalled for 1.")


def test_time_goes_on_while_the_computer_is_suspended() -> None:
    # A laptop cannot be shut here; the clock that knows of it is to be the one that is asked.
    assert elapsed() == pytest.approx(time.clock_gettime(time.CLOCK_BOOTTIME), abs=1)
