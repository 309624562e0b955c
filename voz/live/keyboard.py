"""Typed commands beside the spoken ones, and a key that stops the robot at once."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import termios
import threading
import tty
from collections.abc import Callable, Iterator
from typing import TextIO

from voz.live.messages import Halt, Inbox

STOP_KEYS = (" ", "\x1b", "\x1a")
"""Space, Escape and Ctrl-Z; a space within a line that is being typed belongs to it."""

BACKSPACE = ("\x7f", "\b")
ENTER = ("\r", "\n")

LOOK = 0.1
"""How often the end is looked for, s."""


class Line:
    """A line that is being typed, key by key: pure."""

    def __init__(self) -> None:
        self.text = ""

    def press(self, key: str) -> str | Halt | None:
        """Take a key.

        Args:
            key: a character.

        Returns:
            The line if it is complete, `Halt` for a key that stops, else None.
        """
        if key in STOP_KEYS and not (key == " " and self.text):
            self.text = ""
            return Halt()
        if key in ENTER:
            line, self.text = self.text, ""
            return line
        if key in BACKSPACE:
            self.text = self.text[:-1]
        elif key.isprintable():
            self.text += key
        return None


@contextlib.contextmanager
def keys(inbox: Inbox, typed: Callable[[str], None]) -> Iterator[Line]:
    """Read the keyboard for the length of a `with` block, on a thread of its own.

    Args:
        inbox: gets a `Halt` for the keys that stop.
        typed: called with each line.

    Yields:
        The line that is being typed, for whoever shows it.
    """
    line = Line()
    stream = sys.stdin
    if stream is None or stream.closed or _in_background(stream):
        yield line
        return
    ended = threading.Event()
    read = _read_keys if stream.isatty() else _read_lines
    thread = threading.Thread(
        target=read, args=(stream, line, inbox, typed, ended), name="voz-keyboard", daemon=True
    )
    with _key_by_key(stream):
        thread.start()
        try:
            yield line
        finally:
            ended.set()


def _read_keys(
    stream: TextIO, line: Line, inbox: Inbox, typed: Callable[[str], None], ended: threading.Event
) -> None:
    descriptor = stream.fileno()
    while not ended.is_set():
        if not select.select([descriptor], [], [], LOOK)[0]:
            continue
        data = os.read(descriptor, 1024)
        if not data:  # the terminal is gone
            return
        # Of an arrow key the Escape is enough: who presses keys in haste wants the robot to stop.
        for key in data.decode("utf-8", "replace"):
            done = line.press(key)
            if isinstance(done, Halt):
                inbox.put(done)
                break
            if done is not None:
                typed(done)


def _read_lines(
    stream: TextIO, line: Line, inbox: Inbox, typed: Callable[[str], None], ended: threading.Event
) -> None:
    for text in stream:
        if ended.is_set():
            return
        typed(text)


def _in_background(stream: TextIO) -> bool:
    """Whether reading would suspend the program, as the shell does with `voz run &`."""
    try:
        return stream.isatty() and os.tcgetpgrp(stream.fileno()) != os.getpgrp()
    except OSError:
        return True


@contextlib.contextmanager
def _key_by_key(stream: TextIO) -> Iterator[None]:
    """Let a terminal hand over each key at once and show none; afterwards as it was."""
    if not stream.isatty():
        yield
        return
    before = termios.tcgetattr(stream)
    try:
        tty.setcbreak(stream)
        mode = termios.tcgetattr(stream)
        # Ctrl-Z would suspend a program that drives a robot, Ctrl-S hold up the display.
        mode[tty.CC][termios.VSUSP] = b"\0"
        mode[tty.IFLAG] &= ~termios.IXON
        termios.tcsetattr(stream, termios.TCSANOW, mode)
        yield
    finally:
        with contextlib.suppress(termios.error):  # the terminal may be gone
            termios.tcsetattr(stream, termios.TCSADRAIN, before)
