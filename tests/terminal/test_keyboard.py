"""Typing, key by key, and on a real terminal."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Event, Thread
from typing import TextIO

import pytest
from calls import VOZ
from hypothesis import given
from hypothesis import strategies as st
from programs import wait_until

from voz.inbox import Halt
from voz.terminal.keyboard import BACKSPACE, ENTER, STOP_KEYS, Line, keys

words = st.text(st.characters(codec="utf-8", categories=("L", "N", "P", "S")), min_size=1)
any_keys = st.lists(st.one_of(st.characters(), st.sampled_from([*STOP_KEYS, *ENTER, *BACKSPACE])))


def press(line: Line, keys: str) -> list[str | Halt]:
    return [done for key in keys if (done := line.press(key)) is not None]


@given(words, words)
def test_what_is_typed_comes_with_enter(one: str, other: str) -> None:
    for enter in ENTER:
        assert press(Line(), f"{one} {other}{enter}") == [Halt(), f"{one} {other}"]


@given(any_keys)
def test_escape_stops_whatever_was_typed(keys: list[str]) -> None:
    line = Line()
    press(line, "".join(keys))
    assert line.press("\x1b") == Halt()
    assert line.text == ""


@given(any_keys)
def test_space_stops_whatever_was_typed_and_belongs_to_it(keys: list[str]) -> None:
    line = Line()
    press(line, "".join(keys))
    before = line.text
    assert line.press(" ") == Halt()
    assert line.text == (f"{before} " if before else "")


@given(words, st.sampled_from(["\x1b[A", "\x1bOB", "\x1b[1;5C", "\x1b[3~"]))
def test_an_arrow_key_stops_and_is_no_text_whole_or_split(text: str, arrow: str) -> None:
    line = Line()
    assert press(line, text) == []
    assert press(line, arrow) == [Halt()]
    assert press(line, f"{text}\r") == [text]


@given(any_keys)
def test_what_is_being_typed_can_always_be_printed(keys: list[str]) -> None:
    line = Line()
    for key in keys:
        line.press(key)
        assert line.text.isprintable()


@given(words)
def test_backspace_takes_the_last_letter_back(text: str) -> None:
    line = Line()
    assert press(line, f"{text}x\x7f\n") == [text]
    assert press(line, "\b\b\x7f\n") == [""]


@pytest.fixture
def keyboard(monkeypatch: pytest.MonkeyPatch) -> Iterator[TextIO]:
    """What writes into standard input, a pipe."""
    theirs, ours = os.pipe()
    with os.fdopen(theirs) as stdin, os.fdopen(ours, "w") as keyboard:
        monkeypatch.setattr(sys, "stdin", stdin)
        yield keyboard


def test_what_cannot_be_taken_stops_the_robot_and_what_comes_after_it_is_read(
    keyboard: TextIO,
) -> None:
    stopped, told, lines = [], [], []

    def typed(line: str) -> None:
        if line == "break":
            raise MemoryError
        lines.append(line)

    with keys(lambda: stopped.append(True), typed, told.append):
        print("break", file=keyboard, flush=True)
        wait_until(lambda: told)
        print("go back", file=keyboard, flush=True)
        wait_until(lambda: lines)
    assert lines == ["go back"]
    assert stopped == [True]
    assert told == ["what was typed may be lost (MemoryError()): the robot stops"]


def test_what_fails_once_the_keyboard_is_left_is_no_trouble(
    keyboard: TextIO, begun: Callable[[], list[Thread]]
) -> None:
    taking, left, told = Event(), Event(), []

    def typed(_: str) -> None:
        taking.set()
        assert left.wait(10)
        raise OSError("closed")

    with keys(lambda: told.append("stop"), typed, told.append):
        print("go back", file=keyboard, flush=True)
        assert taking.wait(10)
    left.set()
    wait_until(lambda: not begun())
    assert told == []


@pytest.mark.parametrize(("ends", "taken"), [(True, ["go back", "stop"]), (False, ["go back"])])
def test_a_line_without_an_end_is_taken_at_the_end_of_the_input_and_not_at_that_of_the_run(
    ends: bool, taken: list[str], keyboard: TextIO, begun: Callable[[], list[Thread]]
) -> None:
    lines: list[str] = []
    with keys(lambda: None, lines.append, lines.append):
        print("go back\nstop", end="", file=keyboard, flush=True)
        wait_until(lambda: lines)
        if ends:
            keyboard.close()
            wait_until(lambda: not begun())
    wait_until(lambda: not begun())
    assert lines == taken


class Terminal:
    """A `voz run` in a terminal of its own."""

    def __init__(self, environment: dict[str, str], folder: Path) -> None:
        self._log = folder / "events.jsonl"
        self._ours, theirs = pty.openpty()
        self._open = [self._ours, theirs]
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", 30, 100, 0, 0))
        self.before = termios.tcgetattr(theirs)
        self._theirs = theirs
        self.shown = b""
        arguments = ["run", "--listening", "--no-sound", "--events", str(self._log)]
        self.process = subprocess.Popen(
            [*VOZ, *arguments],
            env=environment | {"TERM": "xterm"},
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            start_new_session=True,
            preexec_fn=take_the_terminal,
        )

    def settings(self) -> list[object]:
        return termios.tcgetattr(self._theirs)

    def type(self, keys: str) -> None:
        os.write(self._ours, keys.encode())

    def look(self) -> str:
        """What the program has shown so far."""
        while select.select([self._ours], [], [], 0.05)[0]:
            self.shown += os.read(self._ours, 65536)
        return self.shown.decode(errors="replace")

    def events(self) -> list[dict[str, object]]:
        text = self._log.read_text() if self._log.exists() else ""
        return [json.loads(line) for line in text.splitlines(keepends=True) if line[-1] == "\n"]

    def wait_for_velocity(self, linear: float) -> None:
        deadline = time.monotonic() + 60
        while not self.events() or self.events()[-1].get("linear") != linear:
            assert self.process.poll() is None, self.look()
            assert time.monotonic() < deadline, self.look()
            self.look()

    def wait_to_see(self, text: str) -> None:
        deadline = time.monotonic() + 20
        while text not in self.look():
            assert time.monotonic() < deadline

    def end(self) -> int:
        """Wait until the program has ended; what it still shows is taken from it."""
        deadline = time.monotonic() + 20
        while self.process.poll() is None:
            assert time.monotonic() < deadline
            self.look()
        self.look()
        return self.process.returncode

    def hang_up(self) -> None:
        """Close the terminal, as its window does."""
        while self._open:
            os.close(self._open.pop())

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        self.hang_up()


def take_the_terminal() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    os.close(os.open(os.ttyname(0), os.O_RDWR))  # now it is the session's own


@pytest.fixture
def terminal(pulse: dict[str, str], tmp_path: Path) -> Iterator[Terminal]:
    terminal = Terminal(pulse, tmp_path)
    yield terminal
    terminal.close()


@pytest.mark.slow
def test_in_a_terminal_commands_are_typed_and_keys_stop(terminal: Terminal) -> None:
    terminal.wait_for_velocity(0)
    for key in STOP_KEYS:
        terminal.type("go forward\r")
        terminal.wait_for_velocity(0.1)
        terminal.type(key)
        terminal.wait_for_velocity(0)
    terminal.type("turn upside down\r")
    terminal.type("go back\r")
    terminal.wait_for_velocity(-0.1)
    heard = [e["text"] for e in terminal.events() if e["type"] == "utterance"]
    assert heard == ["go forward"] * len(STOP_KEYS) + ["turn upside down", "go back"]
    terminal.wait_to_see("drives back at 0.10 m/s")


@pytest.mark.slow
def test_ctrl_s_holds_up_nothing(terminal: Terminal) -> None:
    terminal.wait_for_velocity(0)
    terminal.type("\x13go forward\r")
    terminal.wait_to_see("drives forward at 0.10 m/s")


@pytest.mark.slow
def test_ctrl_c_ends_with_the_terminal_as_it_was(terminal: Terminal) -> None:
    terminal.wait_for_velocity(0)
    assert terminal.settings() != terminal.before
    terminal.type("go forward\r")
    terminal.wait_for_velocity(0.1)
    terminal.type("\x03")
    assert terminal.end() == 130
    assert terminal.settings() == terminal.before
    assert terminal.events()[-1]["linear"] == 0
    assert "\x1b[?25h" in terminal.look()  # the cursor is seen again
    assert "Traceback" not in terminal.look()


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_ends_with_the_terminal_as_it_was(
    number: signal.Signals, code: int, terminal: Terminal
) -> None:
    terminal.wait_for_velocity(0)
    terminal.type("go forward\r")
    terminal.wait_for_velocity(0.1)
    terminal.process.send_signal(number)
    assert terminal.end() == code
    assert terminal.settings() == terminal.before
    assert terminal.events()[-1]["linear"] == 0


@pytest.mark.slow
def test_closing_the_terminal_stops_the_robot_and_ends(terminal: Terminal) -> None:
    terminal.wait_for_velocity(0)
    terminal.type("go forward\r")
    terminal.wait_for_velocity(0.1)
    terminal.hang_up()
    assert terminal.process.wait(20) == 129
    assert terminal.events()[-1]["linear"] == 0
