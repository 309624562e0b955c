"""The sound of one page, over one WebSocket: blocks with a number and a time."""

from __future__ import annotations

import struct
import time
from collections import deque
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from voz.apps.servers.rate_limits import RateLimit
from voz.apps.web.browser_microphone import BrowserMicrophone
from voz.apps.web.page_messages import Begin, Finish, FromMicrophone, Hello, Pong

BLOCK_RATE, BLOCK_BURST = 100.0, 300.0
"""Blocks per second, and at once: a page sends 40 to 60, and more after a delay of the network."""

MAX_CLOCK_LEAD = 0.1
"""A block may seem to come from the future by so much, s; with more its clock is wrong."""

BLOCK_HEADER = struct.Struct("<IId")
"""Number of the block, 0, and when its last sample was heard, ms by the page's clock."""

MAX_BLOCK_SAMPLES = 9_600
"""0.1 s at 96 kHz."""

MAX_CLOCK_ANSWERS = 8
"""Answers from which the two clocks are compared."""


@dataclass(frozen=True, slots=True)
class AudioBlock:
    """A block of sound: its number, when it was heard (ms), and floats from -1 to 1."""

    number: int
    heard: float
    sound: npt.NDArray[np.float32]


def read_block(data: bytes) -> AudioBlock | None:
    """Read a block as the page sends it, 16-bit samples after a header; None if it is invalid."""
    samples, odd = divmod(len(data) - BLOCK_HEADER.size, 2)
    if odd or not 0 < samples <= MAX_BLOCK_SAMPLES:
        return None
    number, zero, heard = BLOCK_HEADER.unpack_from(data)
    if zero or not np.isfinite(heard):
        return None
    sound = np.frombuffer(data, "<i2", offset=BLOCK_HEADER.size).astype(np.float32)
    return AudioBlock(number, heard, sound / np.float32(32768))


class PageClock:
    """How far a page's clock is ahead of this computer's, from pings that it answers."""

    def __init__(self) -> None:
        # The round trip, and how far the page's clock is ahead, s.
        self._answers: deque[tuple[float, float]] = deque(maxlen=MAX_CLOCK_ANSWERS)

    @property
    def is_known(self) -> bool:
        """Whether there is an answer yet."""
        return bool(self._answers)

    def add_answer(self, sent: float, received: float, page: float) -> None:
        """Take the answer to a ping: when it was sent and received, and the page's time, s."""
        self._answers.append((received - sent, page - (received + sent) / 2))

    def age(self, heard: float, now: float) -> float:
        """Return how old sound is, s, that was heard at a time by the page's clock, s."""
        _, ahead = min(self._answers)  # the shortest round trip has the smallest error
        return now - (heard - ahead)


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
            self._microphone.begin_stream(self._rate, message.held)
        elif isinstance(message, Finish):
            self._microphone.end_stream(complete=True)

    def take_block(self, data: bytes) -> float | None:
        """Take a block of sound; raises ValueError if it is invalid, or there are too many.

        Returns:
            How late it was if it is dropped for that, s; None if it counts.
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
