"""Typing, key by key, and on a real terminal."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Event, Thread
from typing import TextIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from live_terminal import Terminal
from programs import PATIENCE, wait_until

from voz.control.messages import Halt
from voz.inbox import Inbox
from voz.language.sentences.command_set import plain_commands
from voz.run.sources import TextCommands
from voz.terminal.keyboard import (
    BACKSPACE,
    ENTER,
    MAX_SPACE_DELAY,
    STOP_KEYS,
    TypedLine,
    read_keyboard,
)

words = st.text(st.characters(codec="utf-8", categories=("L", "N", "P", "S")), min_size=1)
any_keys = st.lists(st.one_of(st.characters(), st.sampled_from([*STOP_KEYS, *ENTER, *BACKSPACE])))

SENTENCES = [
    "start speech", "stop", "stop speech", "go forward", "speed up", "a little to the left",
]  # fmt: skip
KNOWN = TextCommands(lambda: plain_commands(SENTENCES), Inbox({"stop", "stop speech"}), lambda: 0.0)
commands = st.sampled_from(SENTENCES)
command_keys = st.lists(
    st.one_of(commands, st.sampled_from([*"goup ", "  ", "stop ", "\x1b", "\x1b[A", "\x7f", "\r"]))
).map("".join)
pauses = st.sampled_from([0.0, 0.3, MAX_SPACE_DELAY, MAX_SPACE_DELAY + 0.1, 60.0])


def a_line() -> TypedLine:
    return TypedLine(KNOWN.continues)


def press(line: TypedLine, read_keyboard: str, now: float = 1.0) -> list[str | Halt]:
    return [done for key in read_keyboard if (done := line.press(key, now)) is not None]


@given(words, words)
def test_what_is_typed_comes_with_enter(one: str, other: str) -> None:
    for enter in ENTER:
        typed = press(a_line(), f"{one} {other}{enter}")
        assert [line for line in typed if line != Halt()] == [f"{one} {other}"]


@given(commands, st.booleans())
def test_a_command_that_is_typed_at_one_go_stops_nothing_but_by_its_own_stop(
    command: str, capital: bool
) -> None:
    typed = command.upper() if capital else command
    stops = [Halt()] if command == "stop speech" else []
    assert press(a_line(), f"{typed}\r") == [*stops, typed]


@given(command_keys, st.data())
def test_each_space_stops_unless_it_goes_on_with_a_command_that_is_being_typed(
    read_keyboard: str, data: st.DataObject
) -> None:
    line, now, last, before = a_line(), 0.0, 0.0, ""
    for key in read_keyboard:
        now += data.draw(pauses)
        text = line.text
        halted = line.press(key, now) == Halt()
        goes_on = (
            before != " "
            and now - last <= MAX_SPACE_DELAY
            and any(sentence.startswith(f"{text} ") for sentence in SENTENCES)
            and text != "stop"
        )
        assert halted == (key == "\x1b" or (key == " " and not goes_on))
        if key == " ":
            assert line.text == (f"{text.rstrip()} " if text else "")
        elif key not in "\x1b[A":
            last = now
        before = key


@given(any_keys)
def test_escape_and_ctrl_z_stop_whatever_was_typed(read_keyboard: list[str]) -> None:
    line = a_line()
    press(line, "".join(read_keyboard))
    for key in ("\x1b", "\x1a"):
        assert line.press(key, 1.0) == Halt()
        assert line.text == ""


@given(any_keys)
def test_the_second_of_two_spaces_stops_whatever_was_typed(read_keyboard: list[str]) -> None:
    line = a_line()
    press(line, "".join(read_keyboard))
    line.press(" ", 1.0)
    before = line.text
    for _ in range(3):
        assert line.press(" ", 1.0) == Halt()
        assert line.text == before


def test_a_space_after_a_word_that_was_left_lying_stops_and_the_command_may_go_on() -> None:
    line = a_line()
    assert press(line, "speed", now=1.0) == []
    assert press(line, " ", now=1.0 + MAX_SPACE_DELAY + 0.01) == [Halt()]
    assert press(line, "up\r", now=9.0) == ["speed up"]


def test_after_a_space_that_stops_the_rest_of_the_line_is_no_command_of_its_own() -> None:
    assert press(a_line(), "do not go forward\r") == [Halt()] * 3 + ["do not go forward"]


@given(words, st.sampled_from(["\x1b[A", "\x1bOB", "\x1b[1;5C", "\x1b[3~"]))
def test_an_arrow_key_stops_and_is_no_text_whole_or_split(text: str, arrow: str) -> None:
    line = a_line()
    assert press(line, text) == []
    assert press(line, arrow) == [Halt()]
    assert press(line, f"{text}\r") == [text]


@given(any_keys)
def test_what_is_being_typed_can_always_be_printed(read_keyboard: list[str]) -> None:
    line = a_line()
    for key in read_keyboard:
        line.press(key, 1.0)
        assert line.text.isprintable()


@given(words)
def test_backspace_takes_the_last_letter_back(text: str) -> None:
    line = a_line()
    assert press(line, f"{text}x\x7f\n") == [text]
    assert press(line, "\b\b\x7f\n") == [""]


@pytest.fixture
def keyboard(
    monkeypatch: pytest.MonkeyPatch, begun: Callable[[], list[Thread]]
) -> Iterator[TextIO]:
    """What writes into standard input, a pipe."""
    theirs, ours = os.pipe()
    with os.fdopen(theirs) as stdin, os.fdopen(ours, "w") as keyboard:
        monkeypatch.setattr(sys, "stdin", stdin)
        yield keyboard
        wait_until(lambda: not begun())  # or its thread reads what gets the same number next


def test_what_cannot_be_taken_stops_the_robot_and_what_comes_after_it_is_read(
    keyboard: TextIO,
) -> None:
    stopped, told, lines = [], [], []

    def typed(line: str) -> None:
        if line == "break":
            raise MemoryError
        lines.append(line)

    with read_keyboard(lambda: stopped.append(True), typed, KNOWN.continues, told.append):
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
        assert left.wait(PATIENCE)
        raise OSError("closed")

    with read_keyboard(lambda: told.append("stop"), typed, KNOWN.continues, told.append):
        print("go back", file=keyboard, flush=True)
        assert taking.wait(PATIENCE)
    left.set()
    wait_until(lambda: not begun())
    assert told == []


@pytest.mark.parametrize(
    ("ends", "taken"),
    [
        (True, ["go back", "go forward", "stopped", "the robot stops"]),
        (False, ["go back"]),
    ],
)
def test_the_end_of_a_pipe_stops_the_robot_after_its_last_line_and_that_of_the_run_does_not(
    ends: bool, taken: list[str], keyboard: TextIO, begun: Callable[[], list[Thread]]
) -> None:
    done: list[str] = []

    def warn(text: str) -> None:
        done.append(text.rpartition(": ")[2])

    with read_keyboard(lambda: done.append("stopped"), done.append, KNOWN.continues, warn):
        print("go back\ngo forward", end="", file=keyboard, flush=True)
        wait_until(lambda: done)
        if ends:
            keyboard.close()
            wait_until(lambda: not begun())
    wait_until(lambda: not begun())
    assert done == taken


def test_a_pipe_that_ends_without_a_word_stops_nothing(
    keyboard: TextIO, begun: Callable[[], list[Thread]]
) -> None:
    done: list[str] = []
    with read_keyboard(lambda: done.append("stopped"), done.append, KNOWN.continues, done.append):
        keyboard.close()
        wait_until(lambda: not begun())
    assert done == []


@pytest.fixture
def terminal(pulse: dict[str, str], tmp_path: Path) -> Iterator[Terminal]:
    terminal = Terminal(pulse, tmp_path)
    yield terminal
    terminal.close()


@pytest.mark.realtime
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
def test_a_command_of_two_words_is_typed_while_the_robot_moves_and_is_seen_as_it_is_typed(
    terminal: Terminal,
) -> None:
    terminal.wait_for_velocity(0)
    terminal.type("go forward\r")
    terminal.wait_for_velocity(0.1)
    driving = len(terminal.events())
    terminal.type("speed up")
    terminal.wait_to_see("speed up▏")
    terminal.type("\r")
    terminal.wait_for_velocity(0.15)
    since = terminal.events()[driving:]
    assert {event["linear"] for event in since if event["type"] == "cmd_vel"} == {0.1, 0.15}
    assert not [event for event in since if event["type"] == "warning"]
    terminal.type("slow  down\r")  # the second of two spaces stops
    terminal.wait_for_velocity(0)


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
    terminal.type("speed ")  # in the midst of a command
    terminal.wait_to_see("speed ▏")
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
    assert terminal.process.wait(PATIENCE) == 129
    assert terminal.events()[-1]["linear"] == 0
