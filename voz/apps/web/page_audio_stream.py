"""The sound of one page, over one WebSocket."""

from __future__ import annotations

import time

from voz.apps.web.audio_blocks import MAX_CLOCK_LEAD, PageClock, read_block
from voz.apps.web.browser_microphone import BrowserMicrophone
from voz.apps.web.page_messages import Begin, Finish, FromMicrophone, Hello, Pong
from voz.apps.web.rate_limits import RateLimit

BLOCK_RATE, BLOCK_BURST = 100.0, 300.0
"""Blocks per second, and at once: a page sends 40 to 60, and more after a delay of the network."""


class PageAudioStream:
    """Passes the messages of a page on to the microphone; an invalid one raises ValueError."""

    def __init__(self, microphone: BrowserMicrophone, rate: float) -> None:
        """Begin with no sound, at a rate in Hz."""
        self._microphone = microphone
        self._rate = rate
        self._clock = PageClock()
        self._limit = RateLimit(BLOCK_RATE, BLOCK_BURST)
        self._next: int | None = None

    def take_message(self, message: FromMicrophone | None) -> None:
        """Take a message; raises ValueError if it may not come now."""
        if message is None or isinstance(message, Hello):
            raise ValueError
        if isinstance(message, Pong):
            now = time.monotonic()
            if message.t > now:
                raise ValueError
            self._clock.add_answer(message.t, now, message.at / 1000)
        elif isinstance(message, Begin) and self._clock.is_known:
            self._next = None
            self._microphone.begin_stream(self._rate)
        elif isinstance(message, Finish):
            self._microphone.end_stream(whole=True)

    def take_block(self, data: bytes) -> float | None:
        """Take a block of sound.

        Returns:
            How late it was if it is dropped for that, s; None if it counts.

        Raises:
            ValueError: it is invalid, or there are too many.
        """
        now = time.monotonic()
        block = read_block(data)
        if block is None or not self._limit.allows(now):
            raise ValueError
        if not self._clock.is_known:
            return None
        if self._next is not None and block.number != self._next:
            self._microphone.note_gap()
        self._next = block.number + 1
        age = self._clock.age(block.heard / 1000, now)
        if age < -MAX_CLOCK_LEAD:  # the page's clock was set: unknown until the next answer
            self._microphone.note_gap()
            return None
        return self._microphone.take_block(block.sound, now - max(0.0, age))

    def close(self) -> None:
        """Note that the page has gone."""
        self._microphone.note_page_gone()
