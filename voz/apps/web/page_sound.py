"""Takes the sound of one page, over one WebSocket."""

from __future__ import annotations

import time

from voz.apps.web.browser_microphone import BrowserMicrophone
from voz.apps.web.limits import Limit
from voz.apps.web.messages import Begin, Finish, FromMicrophone, Hello, Pong
from voz.apps.web.sound import AHEAD, PageClock, read_block

BLOCKS_EACH_SECOND, BLOCKS_AT_ONCE = 100.0, 300.0
"""Blocks of sound: a page sends 40 to 60, and more after the way was held up."""


class PageSound:
    """From the messages of a page to the microphone; one that it may not send ends the stream."""

    def __init__(self, microphone: BrowserMicrophone, rate: float) -> None:
        """Begin with nothing heard, at a rate in Hz."""
        self._microphone = microphone
        self._rate = rate
        self._clock = PageClock()
        self._limit = Limit(BLOCKS_EACH_SECOND, BLOCKS_AT_ONCE)
        self._next: int | None = None

    def message(self, message: FromMicrophone) -> bool:
        """Take a message; tells whether it is one that may come."""
        if isinstance(message, Pong):
            now = time.monotonic()
            if message.t > now:
                return False
            self._clock.answered(message.t, now, message.at / 1000)
        elif isinstance(message, Begin) and self._clock.known:
            self._next = None
            self._microphone.begin(self._rate)
        elif isinstance(message, Finish):
            self._microphone.end(whole=True)
        return not isinstance(message, Hello)

    def block(self, data: bytes) -> float | None:
        """Take a block of sound.

        Returns:
            How late it was if it is left out for that, s; None if it counts.

        Raises:
            ValueError: it is none, or there are too many.
        """
        now = time.monotonic()
        block = read_block(data)
        if block is None or not self._limit.allows(now):
            raise ValueError
        if not self._clock.known:
            return None
        if self._next is not None and block.number != self._next:
            self._microphone.miss()
        self._next = block.number + 1
        age = self._clock.age(block.heard / 1000, now)
        if age < -AHEAD:  # its clock was set: until it is asked again, nothing is known
            self._microphone.miss()
            return None
        return self._microphone.hear(block.sound, now - max(0.0, age))

    def close(self) -> None:
        """Note that the page has gone."""
        self._microphone.lose()
