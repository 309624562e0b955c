"""A `voz run` in a process of its own that listens to a microphone without hardware."""

from __future__ import annotations

import json
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from calls import VOZ
from programs import PATIENCE

AT_REST = (0.0, 0.0)


BROKEN_WHILE_THERE = """
import os, time
from voz.recognition.stream import Stream
feed = Stream.feed
def broken(self, block):
    if os.path.exists({file!r}):
        {fault}
    return feed(self, block)
Stream.feed = broken
"""


class Arrived(NamedTuple):
    """An event, and when it arrived on the monotonic clock, s."""

    when: float
    event: dict[str, Any]


class LiveRobot:
    """The program, and its events as they arrive."""

    def __init__(self, environment: dict[str, str], arguments: list[str], before: str) -> None:
        *python, program = VOZ
        self.begun = time.monotonic()
        self.process = subprocess.Popen(
            [*python, before + program, "run", "--events", "-", *arguments],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=signals_as_a_terminal_has_them,
        )
        self.arrived: list[Arrived] = []
        self.words = ""
        self._threads = [
            threading.Thread(target=read, daemon=True) for read in (self._read, self._read_words)
        ]
        for thread in self._threads:
            thread.start()

    def _read(self) -> None:
        assert self.process.stdout
        for line in self.process.stdout:
            self.arrived.append(Arrived(time.monotonic(), json.loads(line)))

    def _read_words(self) -> None:
        assert self.process.stderr
        for line in self.process.stderr:
            self.words += line

    def type(self, line: str) -> None:
        """Type a line."""
        assert self.process.stdin
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def wait_for(
        self, sought: Callable[[dict[str, Any]], bool], since: int = 0, seconds: float = PATIENCE
    ) -> Arrived:
        """Wait for an event; `since` leaves out those before it."""
        deadline = time.monotonic() + seconds
        while True:
            found = [arrived for arrived in self.arrived[since:] if sought(arrived.event)]
            if found:
                return found[0]
            assert self.process.poll() is None, self.words
            last = self.warnings(since), self.arrived[-1:]
            assert time.monotonic() < deadline, (self.words, *last)
            time.sleep(0.005)

    def of(self, kind: str, since: int = 0) -> list[dict[str, Any]]:
        """The events of a kind so far."""
        return [arrived.event for arrived in self.arrived[since:] if arrived.event["type"] == kind]

    def warnings(self, since: int = 0) -> list[str]:
        """What it warned of so far."""
        return [event["text"] for event in self.of("warning", since)]

    def commands(self) -> list[str]:
        """What it heard and obeyed so far."""
        return [event["text"] for event in self.of("utterance") if event["obeyed"]]

    def end(self, number: int = signal.SIGTERM, seconds: float = PATIENCE) -> int:
        """End it by a signal; gives its exit code when all its events are there."""
        self.process.send_signal(number)
        try:
            code = self.process.wait(seconds)
        finally:
            self.process.kill()
            for thread in self._threads:
                thread.join()
            for stream in (self.process.stdin, self.process.stdout, self.process.stderr):
                assert stream
                stream.close()
        return code


@contextmanager
def live_robot(
    environment: dict[str, str], *arguments: str, before: str = "", sound: bool = False
) -> Iterator[LiveRobot]:
    """A robot that listens, for the length of a `with` block.

    `before` is Python that is run before it; without `sound` it says its replies in words alone.
    """
    quiet = [] if sound else ["--no-sound"]
    robot = LiveRobot(environment, [*quiet, *arguments], before)
    try:
        robot.wait_for(lambda event: event["type"] == "cmd_vel")
        yield robot
    finally:
        robot.end()


def signals_as_a_terminal_has_them() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def moves(event: dict[str, Any]) -> bool:
    """Whether an event lets the robot move."""
    return event["type"] == "cmd_vel" and velocity(event) != AT_REST


def rests(event: dict[str, Any]) -> bool:
    """Whether an event lets the robot stand still."""
    return event["type"] == "cmd_vel" and velocity(event) == AT_REST


def warns(text: str) -> Callable[[dict[str, Any]], bool]:
    """Whether an event warns of something."""
    return lambda event: event["type"] == "warning" and text in event["text"]


def velocity(event: dict[str, Any]) -> tuple[float, float]:
    return (event["linear"], event["angular"])


def speak(environment: dict[str, str], path: Path) -> None:
    """Speak a recording into the microphone.

    The sound server gets two seconds of it at once: of less, a busy machine delivers the rest too
    late, and what is spoken has gaps, in which `stop speech` becomes `stop`.
    """
    speaking = ["paplay", "--device=mic", "--latency-msec=2000", str(path)]
    subprocess.run(speaking, env=environment, check=True)


def broken_recognizer(file: Path, fault: str) -> str:
    """Python that gives the recognizer a fault, a statement, for as long as a file is there."""
    return BROKEN_WHILE_THERE.format(file=str(file), fault=fault)
