"""The clocks of a run, and what arrives by a time: real time, or that of recordings.

Recordings and lines have the same events at their own pace as without a clock, if the computer is
fast enough.
"""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol, TypeAlias

from voz.control.messages import End, Message
from voz.events import Notice, Partial, Utterance
from voz.inbox import Inbox

Item: TypeAlias = Utterance | Partial | Notice | float
"""An event of a recording or a text, or the time that it has reached, s."""

Source: TypeAlias = Callable[[Callable[[], float]], Iterator[Item]]
"""Recordings, lines or a bag, given what returns the time of the run, s."""

BEATS_PER_SECOND = 10
"""How often `cmd_vel` goes out, also while nothing is said."""

START_DELAY = 0.2
"""Between the start and time 0 of a paced run, s: recordings are decoded meanwhile."""

LATE_TOLERANCE = 0.1
"""In a paced run, a beat that is late by less than this, s, counts as on time."""

MAX_ITEMS_AHEAD = 256
"""Items that are decoded or read before their time."""

HANDOVER_LEAD = 0.02
"""An item is handed over this long before its time, s: before the beat of that time."""

SOURCE_DIED = End(RuntimeError("the source of commands died"))
"""A thread that dies ends the run: the next line may be `stop`."""


def beats_before(t: float) -> int:
    """Count the beats before a time of the run, s."""
    return max(0, math.ceil(round(t * BEATS_PER_SECOND, 6)))


def elapsed() -> float:
    """Return a time that never goes back, s, and goes on while the computer is suspended."""
    # CLOCK_MONOTONIC stands still while a laptop sleeps, and its robot would drive on.
    return time.clock_gettime(getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC))


def wait(ended: threading.Event, seconds: float) -> bool:
    """Wait that long; True, at once, if a run has ended."""
    return ended.wait(seconds)


class Clock(Protocol):
    """The time of a run, s since it began."""

    def now(self) -> float:
        """Return the time, s."""

    def next_before(self, until: float) -> Message | None:
        """Wait for the message that comes before the next beat, due at `until`, s; None if none."""

    def skip(self, seconds: float) -> None:
        """Skip the seconds by which a beat came too late."""


class WallClock:
    """The real time, and what other threads put into an inbox."""

    def __init__(self, inbox: Inbox) -> None:
        """Begin the run now."""
        self._inbox = inbox
        self._begun = elapsed()

    def now(self) -> float:
        """Return the time, s, rounded as events write it."""
        return round(elapsed() - self._begun, 4)

    def next_before(self, until: float) -> Message | None:
        """Wait for a message until the next beat."""
        left = until - (elapsed() - self._begun)
        return self._inbox.take(left) if left > 0 else None

    def skip(self, seconds: float) -> None:
        """Do nothing: real time went on."""


class PacedClock:
    """The time of recordings or lines that come at their own pace, in whole beats.

    It stands still while a beat is late, so that a recording does not catch up in a hurry.
    """

    def __init__(self, inbox: Inbox) -> None:
        """Begin the run in START_DELAY."""
        self._inbox = inbox
        self._begun = elapsed() + START_DELAY
        self._now = self._due = 0.0

    def now(self) -> float:
        """Return when the last beat was due, s; if it was late, when it came."""
        return self._now

    def exactly(self) -> float:
        """Return the time, s; it stands still while the beat does."""
        return min(elapsed() - self._begun, self._due + LATE_TOLERANCE)

    def next_before(self, until: float) -> Message | None:
        """Wait for a message until the next beat."""
        self._due = until
        left = self._begun + until - elapsed()
        message = self._inbox.take(left) if left > 0 else None
        late = elapsed() - self._begun - until
        self._now = until + late if late > LATE_TOLERANCE else until
        return message

    def skip(self, seconds: float) -> None:
        """Continue at the time before the delay."""
        self._begun += seconds
        self._now -= seconds


class RecordedClock:
    """The time of recordings or lines: nothing waits, and each run gives the same events."""

    def __init__(self, items: Iterator[Item]) -> None:
        """Begin at time 0; the items come in the order of their times."""
        self._items = items
        self._item: Item | None = None
        self._now = 0.0

    def now(self) -> float:
        """Return when the next beat is due, s."""
        return self._now

    def next_before(self, until: float) -> Message | None:
        """Return the next item, if its time is not after the next beat."""
        self._now = until
        while True:
            # Not earlier than needed: somebody may still be typing it.
            item = next(self._items, None) if self._item is None else self._item
            if item is not None and time_of(item) > until:
                self._item = item
                return None
            self._item = None
            if item is None:
                return End()
            if not isinstance(item, float):
                return item

    def skip(self, seconds: float) -> None:
        """Do nothing: no beat is late here."""


def time_of(item: Item) -> float:
    """Return when an item comes, s."""
    return item if isinstance(item, float) else item.t


@contextmanager
def pace(items: Iterator[Item], inbox: Inbox, clock: PacedClock) -> Iterator[None]:
    """Put items into an inbox, each at its time, on threads of their own, until the run ends.

    They are in the order of their times; their end, or an error, ends the run.
    """
    ready: queue.Queue[Item | End] = queue.Queue(MAX_ITEMS_AHEAD)
    ended = threading.Event()
    for name, work in (
        ("voz-ahead", lambda: _read_ahead(items, ready, ended)),
        ("voz-pace", lambda: _hand_over(ready, inbox, clock, ended)),
    ):
        threading.Thread(target=work, name=name, daemon=True).start()
    try:
        yield
    finally:
        ended.set()  # nobody waits for the threads: one may wait for a line that never comes


def _read_ahead(
    items: Iterator[Item], ready: queue.Queue[Item | End], ended: threading.Event
) -> None:
    end = SOURCE_DIED
    try:
        for item in items:
            if ended.is_set():
                break
            ready.put(item)
        end = End()
    except Exception as error:  # it is raised where the items are awaited
        end = End(error)
    finally:
        ready.put(end)


def _hand_over(
    ready: queue.Queue[Item | End], inbox: Inbox, clock: PacedClock, ended: threading.Event
) -> None:
    end = SOURCE_DIED
    over = 0.0
    try:
        while not isinstance(item := ready.get(), End):
            if isinstance(item, float):
                over = item
            elif _is_time(item.t, clock, ended):
                inbox.put(item)
        _is_time(beats_before(over) / BEATS_PER_SECOND, clock, ended)
        end = item
    finally:
        inbox.put(end)


def _is_time(t: float, clock: PacedClock, ended: threading.Event) -> bool:
    """Wait until an item is to be handed over; False if the run ends before."""
    while (left := t - HANDOVER_LEAD - clock.exactly()) > 0:  # its time may stand still
        if wait(ended, left):
            return False
    return not ended.is_set()


def warn(inbox: Inbox, clock: Clock, text: str, good: bool = False) -> None:
    """Put a line into the inbox as a Notice, on any thread."""
    inbox.put(Notice(clock.now(), text, good))
