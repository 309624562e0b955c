"""A run of voz in a time of its own: 10 ms at a step, with the real parts and no waiting."""

from __future__ import annotations

import heapq
import itertools
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from unittest import mock

from voz.control.messages import Message
from voz.inbox import Inbox

STEP = 0.01

BEGIN = 1000.0
"""The monotonic clock when a run begins, s."""


class Timeline:
    """A time that goes on in steps, and what happens at them."""

    def __init__(self) -> None:
        self.now = BEGIN  # the monotonic time, s
        self.each: list[Callable[[], None]] = []  # called at each step, after what is due then
        self._numbers = itertools.count()
        self._due: list[tuple[float, int, Callable[[], None]]] = []

    def at(self, t: float, act: Callable[[], None]) -> None:
        """Do something at a time of the run, s."""
        heapq.heappush(self._due, (BEGIN + t, next(self._numbers), act))

    def step(self) -> None:
        """Let a step pass."""
        self.now = round(self.now + STEP, 6)
        while self._due and self._due[0][0] <= self.now:
            heapq.heappop(self._due)[2]()
        for act in self.each:
            act()

    def stall(self, seconds: float) -> None:
        """Let a time pass in which nobody gets a turn, as of a process that is suspended, s."""
        self.now += seconds


class SteppedInbox(Inbox):
    """An inbox whose wait lets time pass."""

    def __init__(self, timeline: Timeline, halts: frozenset[str]) -> None:
        super().__init__(halts)
        self._timeline = timeline

    def take(self, timeout: float) -> Message | None:
        """Take a message, or let time pass until one comes or the limit is over."""
        until = self._timeline.now + timeout
        while (taken := super().take(0)) is None and self._timeline.now < until - STEP / 2:
            self._timeline.step()
        return taken


@contextmanager
def fake_time(timeline: Timeline) -> Iterator[None]:
    """Let voz read its clocks there, for a `with` block, with nothing to read on its input."""

    def now() -> float:
        return timeline.now

    with (
        open(os.devnull) as nothing,  # noqa: PTH123
        mock.patch("time.monotonic", now),
        mock.patch("voz.run.clocks.elapsed", now),
        mock.patch.object(sys, "stdin", nothing),
    ):
        yield
