"""Tests that go by the clock, on a machine that may be too busy for them."""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Callable
from typing import ParamSpec

P = ParamSpec("P")

STALL = 0.04
"""A thread that only sleeps and wakes, and was late by so much, s: nothing here is in time."""

TRIES = 5


class _Metronome:
    """Notices whether the machine lets threads wait."""

    def __init__(self) -> None:
        self.late = 0.0  # at most, s
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def __enter__(self) -> _Metronome:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _work(self) -> None:
        before = time.monotonic()
        while not self._over.wait(0.01):
            now = time.monotonic()
            self.late = max(self.late, now - before - 0.01)
            before = now


def where_the_machine_keeps_up(test: Callable[P, None]) -> Callable[P, None]:
    """Try a test that fails again, if the machine did not let even a sleeping thread wake in time.

    On one that does, the first failure counts.
    """

    @functools.wraps(test)
    def tried(*args: P.args, **kwargs: P.kwargs) -> None:
        for _ in range(TRIES - 1):
            with _Metronome() as metronome:
                try:
                    return test(*args, **kwargs)
                except AssertionError:
                    if metronome.late < STALL:
                        raise
        return test(*args, **kwargs)

    return tried
