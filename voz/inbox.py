"""What the threads at the edges hand to the one loop that drives: `stop` overtakes all of it."""

from __future__ import annotations

import itertools
import queue
from collections import deque
from collections.abc import Collection
from typing import NamedTuple, TypeAlias

from voz.events import Ended, Partial, Utterance, Warning

MAX_QUEUED_MESSAGES = 64
"""Messages that may wait besides those that stop: nobody says so much in the time of a beat."""


class Halt(NamedTuple):
    """Somebody wants the robot to stand still, by a key or a button.

    Attributes:
        why: for people.
        t: when, as a time of the run, s.
    """

    why: str = "stopped by a key"
    t: float = 0.0


class Rehearsal(NamedTuple):
    """From now on commands are understood and not obeyed, or that is over. It is never dropped."""

    on: bool


class End(NamedTuple):
    """The run is over, or fails by an error."""

    error: Exception | None = None


Message: TypeAlias = Utterance | Partial | Ended | Warning | Halt | Rehearsal | End


class TakenMessage(NamedTuple):
    """A message, and whether one that stops the robot came after it but was taken before."""

    message: Message
    overtaken: bool


class Inbox:
    """Messages on their way to the loop; `put` never waits, and signals may call it.

    Signals interrupt the thread that takes the messages, so there is no lock that it could hold:
    deques and `SimpleQueue` can be used in the midst of their own calls.

    Attributes:
        halts: the names of the commands that leave the robot at rest.
        dropped: how many did not fit in, so far.
    """

    def __init__(self, halts: Collection[str]) -> None:
        """Start with nothing in it."""
        self.halts = halts
        self._numbers = itertools.count(1)
        self._urgent: deque[tuple[int, Message]] = deque()
        self._usual: deque[tuple[int, Message]] = deque()
        self._tokens: queue.SimpleQueue[None] = queue.SimpleQueue()  # one for each message
        self._newest_stop = 0
        self.dropped = 0

    def put(self, message: Message) -> None:
        """Hand a message to the loop; if too many wait, it is dropped and counted."""
        number = next(self._numbers)
        if self._stops(message):
            self._newest_stop = number
            waiting = self._urgent
        else:
            waiting = self._usual
        if len(waiting) >= MAX_QUEUED_MESSAGES and not isinstance(message, Rehearsal | End):
            self.dropped += 1  # of those that stop, enough are on their way
            return
        waiting.append((number, message))
        self._tokens.put(None)

    def take(self, timeout: float) -> TakenMessage | None:
        """Take what stops the robot, else the oldest message.

        Args:
            timeout: how long to wait for one, s.

        Returns:
            None if none came.
        """
        try:
            self._tokens.get(timeout=timeout)
        except queue.Empty:
            return None
        if self._urgent:
            return TakenMessage(self._urgent.popleft()[1], False)
        number, message = self._usual.popleft()
        return TakenMessage(message, number < self._newest_stop)

    def _stops(self, message: Message) -> bool:
        """Whether a message ends the motion or the run."""
        if isinstance(message, Utterance):
            return message.accepted and message.name in self.halts
        return isinstance(message, Halt | Rehearsal | End) or (
            isinstance(message, Partial) and message.name in self.halts
        )
