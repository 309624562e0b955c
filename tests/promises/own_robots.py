"""Robots of a user's own in a process of theirs: each notes what it gets, and fails on demand."""

from __future__ import annotations

import os
import re  # noqa: F401 - for faults
import sys  # noqa: F401
import time
from pathlib import Path

from voz.events import Event, Twist
from voz.robot.base import Robot

FAULT, LOG, CHILDREN, WORKS = map(Path, ("fault", "log", "children", "works"))
"""What is done with the next velocity that moves; what came; who was forked; while it works."""


def note(what: object) -> None:
    """Add a line to the log, with the process that writes it, in one piece."""
    with LOG.open("a") as log:
        log.write(f"{os.getpid()} {what}\n")


def fork_and_live() -> None:
    """Fork a process that lives on, with all that was open here."""
    if not os.fork():
        with CHILDREN.open("a") as children:
            children.write(f"{os.getpid()}\n")
        time.sleep(60)


class Unspeakable(Exception):
    def __str__(self) -> str:
        raise ValueError


class Faulty(Robot):
    """Fails as a file says, once."""

    def receive(self, event: Event) -> None:
        if isinstance(event, Twist):
            note(event.linear)
            if event.linear and FAULT.exists():
                fault = FAULT.read_text()
                FAULT.unlink()
                exec(fault)

    def close(self) -> None:
        note("closed")


class Chatty(Faulty):
    """Is lost and there again, in turn, while it works, with much to say."""

    said = 0

    def lost(self) -> str | None:
        self.said += 1
        return "gone " * 2000 if WORKS.exists() and self.said % 2 else None


class Arm(Faulty):
    """Works for as long as it takes."""

    slow = True

    def receive(self, event: Event) -> None:
        super().receive(event)
        if not isinstance(event, Twist) and WORKS.exists():
            note("works")
            while WORKS.exists():
                time.sleep(0.01)
