"""Messages from other threads to the control loop; what stops the robot comes first."""

from __future__ import annotations

import itertools
import threading
import time
from collections import deque
from collections.abc import Collection
from contextlib import suppress

from voz.control.messages import Message, may_be_dropped, overtakes, too_late

MAX_QUEUED_MESSAGES = 64
"""Limit for messages that stop, and for others; nobody says so much in 0.1 s."""

FLOOD_WARNING_INTERVAL = 5.0
"""While messages are dropped, a warning says so once in this time, s."""


class Inbox:
    """Messages to the control loop; `put` never waits, and signal handlers may call it.

    These interrupt the thread that takes messages, so no lock is ever held: deques are reentrant,
    and releasing a lock that only wakes the taker is, too. `SimpleQueue.get` with a time limit is
    no replacement: on CPython 3.10 to 3.12 it may wait forever if the limit passes as it wakes.
    """

    def __init__(self, halts: Collection[str]) -> None:
        self.halts = halts  # names of the commands that stop the robot
        self._numbers = itertools.count(1)
        self._urgent: deque[tuple[int, Message]] = deque()
        self._usual: deque[tuple[int, Message]] = deque()
        self._arrived = threading.Lock()  # held until there is something to take
        self._arrived.acquire()
        self._newest_stop = 0
        self.dropped = 0  # number of messages that were dropped
        self._seen = self._reported = 0  # dropped messages
        self._reported_at = -FLOOD_WARNING_INTERVAL
        self._since = 0.0  # when the first was dropped that was not reported, s

    def put(self, message: Message) -> None:
        """Add a message; if too many wait, it is dropped and counted."""
        number = next(self._numbers)
        waiting = self._usual
        if overtakes(message, self.halts):
            self._newest_stop = number
            waiting = self._urgent
        if len(waiting) >= MAX_QUEUED_MESSAGES and may_be_dropped(message):
            self.dropped += 1  # of those that stop, enough are on their way
            return
        waiting.append((number, message))
        with suppress(RuntimeError):  # not held: whoever takes messages is awake already
            self._arrived.release()

    def take(self, timeout: float) -> Message | None:
        """Take what stops the robot, else the oldest message; None if none came in `timeout` s.

        A command that a stop has overtaken is marked as too late. On one thread only.
        """
        until = time.monotonic() + timeout
        while self.is_empty:
            left = until - time.monotonic()
            if left <= 0 or not self._arrived.acquire(timeout=left):
                break
        if self._urgent:
            return self._urgent.popleft()[1]
        if not self._usual:
            return None
        number, message = self._usual.popleft()
        return too_late(message) if number < self._newest_stop else message

    @property
    def is_empty(self) -> bool:
        """Whether all messages were taken."""
        return not self._urgent and not self._usual

    def flood_report(self, now: float) -> str:
        """Say how many messages were dropped, at the end of a flood or every 5 s; `now` in s."""
        ended, self._seen = self.dropped == self._seen, self.dropped
        dropped = self._seen - self._reported
        if not dropped:
            self._since = now
        elif now - self._reported_at >= FLOOD_WARNING_INTERVAL and (
            ended or now - self._since >= FLOOD_WARNING_INTERVAL
        ):
            self._reported, self._reported_at = self._seen, now
            return f"{dropped} messages came too fast and were dropped"
        return ""
