"""Messages from other threads to the control loop; what stops the robot comes first."""

from __future__ import annotations

import itertools
import threading
import time
from collections import deque
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from voz.events import Ended, Notice, Partial, Utterance

if TYPE_CHECKING:
    from voz.control.table import CommandTable

MAX_QUEUED_MESSAGES = 64
"""Limit for messages that stop, and for others; nobody says so much in 0.1 s."""


@dataclass(frozen=True)
class Halt:
    """The robot is to stand still, by a key or a button.

    Attributes:
        why: for people.
        t: time of the run, s.
    """

    why: str = "stopped by a key"
    t: float = 0.0


@dataclass(frozen=True)
class Rehearsal:
    """Begin or end a rehearsal: commands are understood, but not obeyed. Never dropped."""

    on: bool


@dataclass(frozen=True)
class Renewal:
    """The commands are being renewed, or were: meanwhile nothing moves. Never dropped.

    Attributes:
        why: for people.
        t: time of the run, s.
        under_way: whether it has begun, else it is over.
        table: what the commands do from now on; None if all is as before.
    """

    why: str
    t: float
    under_way: bool
    table: CommandTable | None = None


@dataclass(frozen=True)
class End:
    """The run is over, or has failed by an error."""

    error: BaseException | None = None


Message: TypeAlias = Utterance | Partial | Ended | Notice | Halt | Rehearsal | Renewal | End


@dataclass(frozen=True)
class TakenMessage:
    """A message, and whether a later one that stops the robot was taken before it."""

    message: Message
    overtaken: bool


class Inbox:
    """Messages to the control loop; `put` never waits, and signal handlers may call it.

    These interrupt the thread that takes messages, so no lock is ever held: deques are reentrant,
    and releasing a lock that only wakes the taker is, too. `SimpleQueue.get` with a time limit is
    no replacement: on CPython 3.10 to 3.12 it may wait forever if the limit passes as it wakes.

    Attributes:
        halts: names of the commands that stop the robot.
        dropped: number of messages that were dropped.
    """

    def __init__(self, halts: Collection[str]) -> None:
        self.halts = halts
        self._numbers = itertools.count(1)
        self._urgent: deque[tuple[int, Message]] = deque()
        self._usual: deque[tuple[int, Message]] = deque()
        self._arrived = threading.Lock()  # held until there is something to take
        self._arrived.acquire()
        self._newest_stop = 0
        self.dropped = 0

    def put(self, message: Message) -> None:
        """Add a message; if too many wait, it is dropped and counted."""
        number = next(self._numbers)
        if self._stops(message):
            self._newest_stop = number
            waiting = self._urgent
        else:
            waiting = self._usual
        never_dropped = isinstance(message, Rehearsal | Renewal | End)
        if len(waiting) >= MAX_QUEUED_MESSAGES and not never_dropped:
            self.dropped += 1  # of those that stop, enough are on their way
            return
        waiting.append((number, message))
        with suppress(RuntimeError):  # not held: whoever takes messages is awake already
            self._arrived.release()

    def take(self, timeout: float) -> TakenMessage | None:
        """Take what stops the robot, else the oldest message; None if none came in `timeout` s.

        On one thread only.
        """
        until = time.monotonic() + timeout
        while self.is_empty:
            left = until - time.monotonic()
            if left <= 0 or not self._arrived.acquire(timeout=left):
                break
        if self._urgent:
            return TakenMessage(self._urgent.popleft()[1], False)
        if not self._usual:
            return None
        number, message = self._usual.popleft()
        return TakenMessage(message, number < self._newest_stop)

    @property
    def is_empty(self) -> bool:
        """Whether all messages were taken."""
        return not self._urgent and not self._usual

    def _stops(self, message: Message) -> bool:
        if isinstance(message, Utterance):
            return message.accepted and message.name in self.halts
        return isinstance(message, Halt | Rehearsal | Renewal | End) or (
            isinstance(message, Partial) and message.name in self.halts
        )
