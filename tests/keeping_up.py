"""Tests that go by the clock, on a machine that may be too busy for them."""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec

P = ParamSpec("P")

STALL = 0.04
"""A thread that only sleeps and wakes, and was late by so much, s: nothing here is in time."""

CROWDED = 0.2
"""Somebody waited for a processor for this part of the time: so may the test have."""

PRESSURE = Path("/proc/pressure/cpu")
"""Which tells that: https://docs.kernel.org/accounting/psi.html"""

TRIES = 5


def waited_for_processors() -> float:
    """How long somebody waited for a processor since the computer started, s; 0 if untold."""
    if not PRESSURE.exists():
        return 0.0
    return int(PRESSURE.read_text().split("total=")[1].split()[0]) / 1e6


class Metronome:
    """Notices whether the machine lets threads wait."""

    def __init__(self) -> None:
        self.late = 0.0  # at most, s
        self._begun, self._waited = time.monotonic(), waited_for_processors()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def __enter__(self) -> Metronome:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    @property
    def keeps_up(self) -> bool:
        """Whether it did not."""
        crowded = waited_for_processors() - self._waited
        return self.late < STALL and crowded < CROWDED * (time.monotonic() - self._begun)

    def _work(self) -> None:
        before = time.monotonic()
        while not self._over.wait(0.01):
            now = time.monotonic()
            self.late = max(self.late, now - before - 0.01)
            before = now


def where_the_machine_keeps_up(test: Callable[P, None]) -> Callable[P, None]:
    """Try a test that fails again, if the machine had no time for it.

    It had none if it did not let even a sleeping thread wake in time, or if somebody waited for
    a processor often. On one that has, the first failure counts.
    """

    @functools.wraps(test)
    def tried(*args: P.args, **kwargs: P.kwargs) -> None:
        for _ in range(TRIES - 1):
            with Metronome() as metronome:
                try:
                    return test(*args, **kwargs)
                except AssertionError:
                    if metronome.keeps_up:
                        raise
        return test(*args, **kwargs)

    return tried
