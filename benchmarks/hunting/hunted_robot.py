"""Robots of a user's own: they tell an observer each velocity, and one of them breaks on demand.

The observer's FIFO and the file that names a fault come by the environment, for the program may
run a robot in a process of its own.
"""

from __future__ import annotations

import os
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from voz.events import Event, Twist
from voz.robot.base import Robot

HANGS = 3.0
"""s"""

MOAN = 0.25
"""s, long enough to be noticed"""

EXPLODES = 25
"""Letters for a regular expression that holds Python for a second or so; each doubles its time."""


class Base(Robot):
    """Tells what it is to do, and when that arrived."""

    def open(self) -> None:
        self._observer = os.open(os.environ["HUNT_OBSERVER"], os.O_WRONLY | os.O_NONBLOCK)

    def receive(self, event: Event) -> None:
        if isinstance(event, Twist):
            told = f"{type(self).__name__} {time.monotonic()} {event.linear} {event.angular}\n"
            os.write(self._observer, told.encode())


class Bad(Base):
    """The same, and then does what a file says, once."""

    _moans_until = 0.0

    def receive(self, event: Event) -> None:
        super().receive(event)
        file = Path(os.environ["HUNT_ROBOT_FAULT"])
        if file.exists():
            fault = file.read_text()
            file.unlink()
            FAULTS[fault](self)

    def lost(self) -> str | None:
        """Be lost and there again, in turn, while it moans, with much to say."""
        left = self._moans_until - time.monotonic()
        return "it creaks " * 2000 if left > 0 and int(left / MOAN) % 2 else None

    def moan(self) -> None:
        self._moans_until = time.monotonic() + 8 * MOAN


class Unspeakable(Exception):
    """An error that cannot be told."""

    def __str__(self) -> str:
        raise ValueError("there are no words for it")


def _raise(error: BaseException) -> NoReturn:
    raise error


FAULTS: dict[str, Callable[[Bad], object]] = {
    "raises": lambda _: _raise(OSError("the cable is out")),
    "calls sys.exit": lambda _: sys.exit(3),
    "is interrupted": lambda _: _raise(KeyboardInterrupt()),
    "cannot tell its error": lambda _: _raise(Unspeakable()),
    "hangs": lambda _: time.sleep(HANGS),
    "holds Python": lambda _: re.match("(a+)+$", "a" * EXPLODES + "b"),
    "moans": Bad.moan,
}
