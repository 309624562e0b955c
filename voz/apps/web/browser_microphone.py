"""The microphone of the driving page, for the thread that listens."""

from __future__ import annotations

import queue
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeAlias

from voz.audio import Samples
from voz.audio.segment import NO_SAMPLES
from voz.audio.sound_files import Mono, Resampler

BROWSER_SOURCE = "browser"
"""The source of utterances from there."""

MAX_AUDIO_AGE = 0.3
"""Sound that is older when it arrives is dropped, s: a late `forward` must never drive."""

MAX_BROWSER_BLOCKS = 60
"""Blocks that wait for a slow computer, about a second; then all are dropped."""

POLL_INTERVAL = 0.1
"""How often the thread that listens looks for its end while nobody speaks, s."""

LATE_WARNING_INTERVAL = 5.0
"""Between two warnings of late or missing sound, s."""


@dataclass(frozen=True, slots=True)
class _Block:
    """A block, its rate in Hz, when it was heard on the monotonic clock, s, and `addressed`."""

    sound: Mono
    rate: float
    when: float
    addressed: bool


@dataclass(frozen=True, slots=True)
class _End:
    """A stream ends, whole or not."""

    complete: bool


_Item: TypeAlias = _Block | _End


class BrowserMicrophone:
    """The sound of the driving page, stream by stream.

    The server's thread calls the methods with a verb, the thread that listens iterates. Its
    attributes are those of `OpenMicrophone`.
    """

    name = "of the operator's browser"
    blocks_lost = 0

    def __init__(self, warn: Callable[[str], None]) -> None:
        """Begin with no stream; `warn` takes a line when sound is late or missing."""
        self.arrived = time.monotonic()
        self.complete = True
        self.addressed = False
        self._warn = warn
        self._warned_at = -LATE_WARNING_INTERVAL
        self._waiting: queue.Queue[_Item] = queue.Queue(MAX_BROWSER_BLOCKS)
        self._resampler: Resampler | None = None  # of the current stream
        self._rate = 0.0
        self._held = False  # the button, for the current stream
        self._expected = False
        self._last = 0.0  # when sound came that was not late, on the monotonic clock, s
        self._broken = False  # sound is missing, and the stream was ended for that

    @property
    def alive(self) -> float:
        """When sound last arrived, on the monotonic clock, s; now while none is expected."""
        return self._last if self._expected else time.monotonic()

    @alive.setter
    def alive(self, when: float) -> None:
        self._last = when

    @property
    def is_expected(self) -> bool:
        """Whether sound is expected: the button is held, or the page is hands-free."""
        return self._expected

    @property
    def is_hands_free(self) -> bool:
        """Whether sound is expected without a button that is held."""
        return self._expected and not self._held

    def begin_stream(self, rate: float, held: bool) -> None:
        """Expect sound from now on, at so many Hz; `held`: for as long as the button is held."""
        self.end_stream(complete=False)
        self._last, self._rate, self._held = time.monotonic(), rate, held
        self._expected, self._broken = True, False

    def take_block(self, sound: Mono, when: float) -> float | None:
        """Take a block that was heard at a time on the monotonic clock, s.

        Returns:
            How late it was if it is dropped for that, s; None if it counts.
        """
        if not self._expected:
            return None
        now = time.monotonic()
        if now - when > MAX_AUDIO_AGE:
            self._break(f"sound of the browser came {now - when:.1f} s late and is dropped")
            return now - when
        self._last, self._broken = now, False
        self._put(_Block(sound, self._rate, when, self._held))
        return None

    def note_gap(self) -> None:
        """Note that blocks are missing before the next one."""
        if self._expected:
            self._break("sound of the browser is missing: the network is too slow")

    def end_stream(self, complete: bool) -> None:
        """Expect no more sound; an open segment is decided if the stream is whole, else dropped."""
        if self._expected:
            self._expected = False
            self._put(_End(complete))

    def note_page_gone(self) -> None:
        """Note that the page has gone; if it was to speak, sound is still expected (S5)."""
        if self._expected:
            self._put(_End(False))

    def __iter__(self) -> Iterator[Samples]:
        return self

    def __next__(self) -> Samples:
        try:
            item = self._waiting.get(timeout=POLL_INTERVAL)
        except queue.Empty:
            self.arrived = time.monotonic()
            return NO_SAMPLES
        if isinstance(item, _End):
            self.complete, self._resampler = item.complete, None
            raise StopIteration
        self._resampler = self._resampler or Resampler(item.rate)
        self.arrived, self.addressed = item.when, item.addressed
        return self._resampler.feed(item.sound)

    def _break(self, why: str) -> None:
        """End the stream without its open segment, in which words may be missing."""
        now = time.monotonic()
        if not self._broken:
            self._broken = True
            self._put(_End(False))
        if now - self._warned_at >= LATE_WARNING_INTERVAL:
            self._warned_at = now
            self._warn(why)

    def _put(self, item: _Item) -> None:
        try:
            self._waiting.put_nowait(item)
        except queue.Full:  # nobody needs sound that has waited for a second
            with suppress(queue.Empty):
                while True:
                    self._waiting.get_nowait()
            self._waiting.put_nowait(_End(False))
