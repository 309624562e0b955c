"""Recordings and lines at their own pace: the same events, by the clock."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from queue import SimpleQueue

import pytest
from recordings import FIXTURES, GO_BACK

from voz.config import Safety
from voz.control.controller import RULES
from voz.errors import AudioError
from voz.events import Event, Reply, Twist, Utterance, Warning
from voz.live.messages import Halt, Inbox
from voz.pipeline import Pipeline, drive_by_recordings, drive_by_text, running
from voz.realtime import RealtimePipeline
from voz.recognition.recognizer import Recognizer

COMMANDS = [*RULES, "start speech"]
LINES = ["start speech", "go forward", "-", "turn left", "stop"]


class Clocked:
    """The events of a run by the clock, and when each came."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.times: list[float] = []

    def receive(self, event: Event) -> None:
        self.events.append(event)
        self.times.append(time.monotonic())


def typed(lines: list[str], kind: type[Pipeline], run: Clocked) -> list[Event]:
    with running([run.receive], Safety(), None, make=kind) as drive:
        drive_by_text(drive, lines, COMMANDS)
    return run.events


def test_typed_lines_give_the_same_events_each_in_its_tenth_of_a_second() -> None:
    run = Clocked()
    assert typed(LINES, RealtimePipeline, run) == typed(LINES, Pipeline, Clocked())
    beats = [t for t, e in zip(run.times, run.events, strict=True) if isinstance(e, Twist)]
    begun = beats[0]
    # The last is the zero that ends the run, and that comes at once.
    assert all(t - begun > n / 10 - 0.05 for n, t in enumerate(beats[:-1]))


def test_recordings_give_the_same_events(recognizer: Recognizer) -> None:
    paths = [FIXTURES / "commands" / "festival_slt__start_speech.flac", GO_BACK, Path("none.wav")]

    def spoken(kind: type[Pipeline]) -> tuple[list[Event], list[str]]:
        run = Clocked()
        with running([run.receive], Safety(), None, make=kind) as drive:
            errors = drive_by_recordings(drive, paths, recognizer)
        return run.events, errors

    assert spoken(RealtimePipeline) == spoken(Pipeline)


def test_an_utterance_takes_effect_at_its_time(recognizer: Recognizer) -> None:
    run = Clocked()
    with running([run.receive], Safety(), None, make=RealtimePipeline) as drive:
        drive_by_recordings(drive, [GO_BACK], recognizer)
    came = dict(zip(run.events, run.times, strict=True))
    begun = came[Twist(0.0, 0.0, 0.0)]
    (heard,) = [event for event in run.events if isinstance(event, Utterance)]
    assert came[heard] - begun > heard.t - 0.05


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

    with running([receive], Safety(), None, make=RealtimePipeline) as drive:
        drive_by_text(drive, slowly(), COMMANDS)
    times = [event.t for event in events if isinstance(event, Twist)]
    assert times == [n / 10 for n in range(len(times))]
    assert [e.text for e in events if isinstance(e, Utterance)][-1] == "stop"


def test_what_goes_wrong_while_reading_ahead_ends_the_run() -> None:
    def broken() -> Iterator[str]:
        yield "start speech"
        raise AudioError("the disk is gone")

    events: list[Event] = []
    with (
        pytest.raises(AudioError, match="the disk is gone"),
        running([events.append], Safety(), None, make=RealtimePipeline) as drive,
    ):
        drive_by_text(drive, broken(), COMMANDS)
    assert events[-1].t == 0.1
    assert isinstance(events[-1], Twist)


def test_s5_a_robot_that_is_lost_stops_the_run_and_is_named() -> None:
    events: list[Event] = []
    moved = 0

    def lost() -> str | None:
        nonlocal moved
        moved += any(isinstance(event, Twist) and event.linear for event in events)
        return "the robot x is lost (gone)" if 2 <= moved < 4 else None

    make = partial(RealtimePipeline, lost={"x": lost})
    with running([events.append], Safety(), None, make=make) as drive:
        drive_by_text(drive, ["start speech", "go forward", *"------"], COMMANDS)
    kept = [event for event in events if isinstance(event, Twist | Warning)]
    spells = [list(spell) for _, spell in itertools.groupby(kept, type)]
    assert [e.linear for e in spells[0]] == [0, 0.1, 0.1]
    assert [e.text for e in spells[1]] == ["the robot x is lost (gone): the robot stops"]
    assert [e.text for e in spells[3]] == ["x is there; the robot waits for a command"]
    assert not any(e.linear for e in [*spells[2], *spells[4]])


def test_what_other_threads_tell_is_taken_with_the_beat() -> None:
    inbox: Inbox = SimpleQueue()
    inbox.put(Warning(0.0, "bump"))
    inbox.put(Halt())
    events: list[Event] = []
    make = partial(RealtimePipeline, inbox=inbox)
    with running([events.append], Safety(), None, listening=True, make=make) as drive:
        drive_by_text(drive, ["go forward", "-"], COMMANDS)
    assert [e.text for e in events if isinstance(e, Warning)] == ["bump"]
    assert not any(isinstance(event, Reply) for event in events)
    assert [e.linear for e in events if isinstance(e, Twist)] == [0, 0, 0]
