"""Typed commands, and keys that stop the robot at once."""

from __future__ import annotations

import codecs
import contextlib
import os
import select
import sys
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from typing import TextIO

from voz.control.messages import Halt

ESCAPE = "\x1b"

SPACE = " "

STOP_KEYS = (SPACE, ESCAPE, "\x1a")
"""Space, Escape and Ctrl-Z. A space within a command does not stop, see `TypedLine`."""

MAX_SPACE_DELAY = 2.0
"""Between a word and a space that continues it, s; a later space stops the robot."""

ESCAPE_SEQUENCE_STARTS = "[O"
"""What follows the Escape of an arrow key; it ends with a character not in `ESCAPE_PARAMETERS`."""

ESCAPE_PARAMETERS = "0123456789;"

BACKSPACE = ("\x7f", "\b")
ENTER = ("\r", "\n")

MAX_LINE_LENGTH = 200
"""Characters of a line that are kept; a command has fewer."""

END_CHECK_INTERVAL = 0.1
"""Between checks of whether to end, s."""

PIPE_BYTES = 65536
"""All that a pipe of Linux holds (pipe(7)): its last line may be a `stop`."""


class TypedLine:
    """A line that is being typed, key by key.

    A space between two words of a command, just after the first, is text. Any other space stops the
    robot; it stays in the line, so that the rest is not taken for a command.
    """

    def __init__(self, continues: Callable[[str], bool]) -> None:
        """Start an empty line; `continues` returns whether a space after a text is in a command."""
        self.text = ""
        self._continues = continues
        self._key = ""  # the beginning of one that sends several characters
        self._typed_at = 0.0  # the last character, s

    def press(self, character: str, now: float) -> str | Halt | None:
        """Take a character, and the time, s.

        Returns:
            The line if it is complete, `Halt` for a key that stops, else None.
        """
        if character not in STOP_KEYS and self._belongs_to_a_key(character):
            return None
        if character == SPACE:
            return self._space(now)
        if character in STOP_KEYS:
            self._key = character if character == ESCAPE else ""
            self.text = ""
            return Halt()
        if character in ENTER:
            line, self.text = self.text, ""
            return line
        if character in BACKSPACE:
            self.text, self._typed_at = self.text[:-1], now
        elif character.isprintable() and len(self.text) < MAX_LINE_LENGTH:
            self.text, self._typed_at = self.text + character, now
        return None

    def _space(self, now: float) -> Halt | None:
        self._key = ""
        text = self.text
        if not text or text.endswith(SPACE):
            return Halt()
        self.text += SPACE
        just_now = now - self._typed_at <= MAX_SPACE_DELAY
        return (
            None if just_now and len(text) < MAX_LINE_LENGTH and self._continues(text) else Halt()
        )

    def _belongs_to_a_key(self, character: str) -> bool:
        """Whether a character is part of a key: an arrow sends Escape, a bracket and a letter."""
        if self._key == ESCAPE and character in ESCAPE_SEQUENCE_STARTS:
            self._key += character
            return True
        belongs = len(self._key) > 1
        if not belongs or character not in ESCAPE_PARAMETERS:
            self._key = ""
        return belongs


@contextlib.contextmanager
def read_keyboard(
    stop: Callable[[], None],
    typed: Callable[[str], None],
    continues: Callable[[str], bool],
    warn: Callable[[str], None],
) -> Iterator[TypedLine]:
    """Read the keyboard in a `with` block, on a thread of its own; give the line being typed.

    `stop` is called for each key that stops the robot. `continues` returns whether a space after a
    text is part of a command. `warn` is called if input may be lost. A program that types by a pipe
    may drive: when it ends, the robot stops.
    """
    line = TypedLine(continues)
    stream = sys.stdin
    if not can_read_input():
        yield line
        return
    ended = threading.Event()
    take = _keys_into(line, stop, typed) if stream.isatty() else _lines_into(typed)

    def read() -> None:
        # Whatever happens: a terminal full of unread keys takes no Ctrl-C either.
        given = False
        while not ended.is_set():
            try:
                for text in _texts(stream.fileno(), ended):
                    given = True
                    take(text)
                if given and not ended.is_set() and not stream.isatty():
                    take("\n")  # the last line may have no end
                    stop()
                    warn("the program whose output voz reads has ended: the robot stops")
                return
            except BaseException as error:  # what was typed to stop it may be lost
                if ended.is_set():  # nothing drives any more, and the stream may be closed
                    return
                stop()
                warn(f"what was typed may be lost ({error!r}): the robot stops")
                ended.wait(END_CHECK_INTERVAL)

    thread = threading.Thread(target=read, name="voz-keyboard", daemon=True)
    with _key_by_key(stream):
        thread.start()
        try:
            yield line
        finally:
            ended.set()


def can_read_input() -> bool:
    """Whether standard input can be read; a program in the background cannot."""
    stream = sys.stdin
    if stream is None or stream.closed or _in_background(stream):
        return False
    return not os.path.samefile(stream.fileno(), os.devnull)  # noqa: PTH121


def _texts(descriptor: int, ended: threading.Event) -> Iterator[str]:
    """Yield what is typed as it comes; bytes that are not UTF-8 are replaced."""
    decoder = codecs.getincrementaldecoder("utf-8")("replace")
    while not ended.is_set():
        if not select.select([descriptor], [], [], END_CHECK_INTERVAL)[0]:
            continue
        try:
            data = os.read(descriptor, PIPE_BYTES)
        except OSError:
            return  # the terminal is gone
        if not data:
            return
        yield decoder.decode(data)


def _keys_into(
    line: TypedLine, stop: Callable[[], None], typed: Callable[[str], None]
) -> Callable[[str], None]:
    def take(text: str) -> None:
        now = time.monotonic()
        for character in text:
            done = line.press(character, now)
            if isinstance(done, Halt):
                stop()
            elif done is not None:
                typed(done)

    return take


def _lines_into(typed: Callable[[str], None]) -> Callable[[str], None]:
    begun = ""

    def take(text: str) -> None:
        nonlocal begun
        *lines, begun = (begun + text).split("\n")
        begun = begun[:MAX_LINE_LENGTH]  # a longer line is no command, and may never end
        for line in lines:
            typed(line[:MAX_LINE_LENGTH])

    return take


def _in_background(stream: TextIO) -> bool:
    """Whether reading would suspend the program, as after `voz run &`."""
    try:
        return stream.isatty() and os.tcgetpgrp(stream.fileno()) != os.getpgrp()
    except OSError:
        return True


@contextlib.contextmanager
def _key_by_key(stream: TextIO) -> Iterator[None]:
    """Let a terminal pass on each key at once, without echo, in a `with` block."""
    if not stream.isatty():
        yield
        return
    before = termios.tcgetattr(stream)
    try:
        tty.setcbreak(stream)
        mode = termios.tcgetattr(stream)
        # Ctrl-Z would suspend a program that drives a robot, Ctrl-S stop the display.
        mode[tty.CC][termios.VSUSP] = b"\0"
        mode[tty.IFLAG] &= ~termios.IXON
        termios.tcsetattr(stream, termios.TCSANOW, mode)
        yield
    finally:
        with contextlib.suppress(termios.error):  # the terminal may be gone
            # TCSANOW: a terminal that was stopped by Ctrl-S never takes waiting output.
            termios.tcsetattr(stream, termios.TCSANOW, before)
