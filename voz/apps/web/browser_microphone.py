"""The microphone of the page that drives, for the thread that listens."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import NamedTuple, TypeAlias

import numpy as np

from voz.apps.web.sound import OLDEST
from voz.audio import Samples
from voz.audio.capture.resampling import Mono, Resampler

BROWSER = "browser"
"""The source of what is heard there."""

MOST_WAITING = 60
"""Blocks, about a second, that wait for a computer that is slow; then all are left out."""

LOOK = 0.1
"""How often the thread that listens looks after its end while nobody speaks, s."""

TOLD_EVERY = 5.0
"""Of sound that is late again and again a user wants to read a line now and then, s."""

NOTHING: Samples = np.empty(0, np.int16)


class _Heard(NamedTuple):
    """A block, its rate in Hz, and when it was heard on the monotonic clock, s."""

    sound: Mono
    rate: float
    when: float


class _End(NamedTuple):
    """A stream ends, whole or not."""

    whole: bool


_Item: TypeAlias = _Heard | _End


class BrowserMicrophone:
    """What the page that drives lets be heard, stream by stream.

    The server's thread calls `begin`, `hear` and `end`, the thread that listens all else. Its
    attributes are those of `OpenMicrophone`.
    """

    name = "of the operator's browser"
    blocks_lost = 0

    def __init__(self, warn: Callable[[str], None]) -> None:
        """Begin with nobody speaking; what is late is told by `warn`."""
        self.arrived = time.monotonic()
        self.whole = True
        self._warn = warn
        self._told = -TOLD_EVERY  # when
        self._waiting: queue.Queue[_Item] = queue.Queue(MOST_WAITING)
        self._resampler: Resampler | None = None  # of the stream under way
        self._rate = 0.0
        self._expected = False  # somebody holds the button, or speaks hands-free
        self._last = 0.0  # when sound came that was not late, on the monotonic clock, s
        self._broken = False  # sound is missing, and the stream was ended for that

    @property
    def alive(self) -> float:
        """When it last handed something over; now, while nobody is to speak."""
        return self._last if self._expected else time.monotonic()

    @alive.setter
    def alive(self, when: float) -> None:
        self._last = when

    @property
    def expected(self) -> bool:
        """Whether somebody holds the button, or speaks hands-free."""
        return self._expected

    def begin(self, rate: float) -> None:
        """Expect sound from now on, at so many Hz."""
        self.end(whole=False)
        self._last, self._rate = time.monotonic(), rate
        self._expected, self._broken = True, False

    def hear(self, sound: Mono, when: float) -> float | None:
        """Take a block.

        Args:
            sound: floats from -1 to 1.
            when: it was heard, on the monotonic clock, s.

        Returns:
            How late it was if it is left out for that, s; None if it counts.
        """
        if not self._expected:
            return None
        now = time.monotonic()
        if now - when > OLDEST:
            self._break(f"sound of the browser came {now - when:.1f} s late and is left out")
            return now - when
        self._last, self._broken = now, False
        self._put(_Heard(sound, self._rate, when))
        return None

    def miss(self) -> None:
        """Note that blocks are missing before the next one."""
        if self._expected:
            self._break("sound of the browser is missing: the way to it is too slow")

    def end(self, whole: bool) -> None:
        """Expect no more; what is open is settled, if the stream is whole, else it is forgotten."""
        if self._expected:
            self._expected = False
            self._put(_End(whole))

    def lose(self) -> None:
        """Note that the page has gone though it was to speak: sound is still expected (S5)."""
        if self._expected:
            self._put(_End(False))

    def __iter__(self) -> Iterator[Samples]:
        return self

    def __next__(self) -> Samples:
        try:
            item = self._waiting.get(timeout=LOOK)
        except queue.Empty:
            self.arrived = time.monotonic()
            return NOTHING
        if isinstance(item, _End):
            self.whole, self._resampler = item.whole, None
            raise StopIteration
        self._resampler = self._resampler or Resampler(item.rate)
        self.arrived = item.when
        return self._resampler.feed(item.sound)

    def _break(self, why: str) -> None:
        """End the stream without what is open in it: words may be missing from that."""
        now = time.monotonic()
        if not self._broken:
            self._broken = True
            self._put(_End(False))
        if now - self._told >= TOLD_EVERY:
            self._told = now
            self._warn(why)

    def _put(self, item: _Item) -> None:
        try:
            self._waiting.put_nowait(item)
        except queue.Full:  # nobody needs sound that has waited for a second
            with suppress(queue.Empty):
                while True:
                    self._waiting.get_nowait()
            self._waiting.put_nowait(_End(False))


@contextmanager
def opened(microphone: BrowserMicrophone) -> Iterator[BrowserMicrophone]:
    """Hand a microphone to the thread that listens; it is there all the time."""
    yield microphone
