"""What a base is asked to do, seen outside the program, and how late this computer is meanwhile."""

from __future__ import annotations

import os
import select
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

TICK = 0.01

MOST_WAITED = 0.5
"""What that may count for at most, s: it need not have been the program that waited."""


PRESSURE = Path("/proc/pressure/cpu")
"""How long threads waited for a processor: https://docs.kernel.org/accounting/psi.html"""


class Seen(NamedTuple):
    """A velocity that reached somebody: when on the monotonic clock, s; m/s and rad/s."""

    who: str
    at: float
    linear: float
    angular: float

    @property
    def moves(self) -> bool:
        return (self.linear, self.angular) != (0.0, 0.0)


class Observer:
    """Takes what bases tell through a FIFO, for the length of a `with` block.

    It stamps nothing: a busy harness changes no time. A FIFO is no disk that could be full.
    It notes how late its own thread wakes, and how long any thread of this computer waited for a
    processor, which tells how late everybody may be.
    """

    def __init__(self, path: Path) -> None:
        os.mkfifo(path)
        self._fifo = os.open(path, os.O_RDWR)  # for writing too: so there is never an end
        self.seen: list[Seen] = []
        self._late: list[tuple[float, float, float]] = []
        self._ended = threading.Event()
        self._threads = [threading.Thread(target=work) for work in (self._read, self._doze)]

    def __enter__(self) -> Observer:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        for thread in self._threads:
            thread.join()
        os.close(self._fifo)

    def lateness(self, since: float) -> float:
        """The worst of this computer since then, s."""
        noted = [(late, waited) for at, late, waited in self._late if at >= since]
        if not noted:
            return 0.0
        waited = min(noted[-1][1] - noted[0][1], MOST_WAITED)
        return max(waited, *(late for late, _ in noted))

    def moves(self, since: float) -> bool:
        """Whether somebody was asked to move since then."""
        return any(seen.moves and seen.at > since for seen in list(self.seen))

    def _doze(self) -> None:
        while not self._ended.is_set():
            before = time.monotonic()
            time.sleep(TICK)
            now = time.monotonic()
            self._late.append((now, now - before - TICK, waited_for_processors()))

    def _read(self) -> None:
        rest = b""
        while not self._ended.is_set():
            if select.select([self._fifo], [], [], 0.1)[0]:
                *lines, rest = (rest + os.read(self._fifo, 65536)).split(b"\n")
                for line in lines:
                    who, *numbers = line.decode().split()
                    self.seen.append(Seen(who, *map(float, numbers)))


def waited_for_processors() -> float:
    """Since the computer started, s; 0 where Linux does not report it."""
    if not PRESSURE.exists():
        return 0.0
    return int(PRESSURE.read_text().split("total=")[1].split()[0]) / 1e6


class Judged(NamedTuple):
    """How long it took until all stood still, s; what is wrong, or nothing."""

    took: float
    wrong: str


def judge(seen: Sequence[Seen], since: float, bound: float, blind: float = 0.0) -> Judged:
    """Judge whether all stand still in time, and go on to do so.

    Args:
        seen: what arrived up to now.
        since: when it had to stop, on the monotonic clock, s.
        bound: it has so long for it, s.
        blind: so long the robot `Bad` can take nothing, s.
    """
    longest, wrong = 0.0, []
    for who in dict.fromkeys(each.who for each in seen):
        own = [each for each in seen if each.who == who]
        moved = [each for each in own if each.moves]
        if not moved:
            continue
        still = own[own.index(moved[-1]) + 1 :]
        in_time = since + bound + (blind if who == "Bad" else 0)
        if moved[-1].at > since + bound:
            wrong.append(f"{who} is asked to move {moved[-1].at - since:.2f} s later")
        elif not still or still[0].at > in_time:
            when = f"only {still[0].at - since:.2f} s later" if still else "never"
            wrong.append(f"{who} gets zero {when}")
        if who != "Bad":
            longest = max(longest, (still or moved)[0 if still else -1].at - since)
    return Judged(longest, "; ".join(wrong))
