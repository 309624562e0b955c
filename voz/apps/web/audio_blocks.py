"""Blocks of a page's sound, with a number and a time. Pure."""

from __future__ import annotations

import struct
from collections import deque
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

MAX_AUDIO_AGE = 0.3
"""Sound that is older when it arrives is dropped, s: a late `forward` must never drive."""

MAX_CLOCK_LEAD = 0.1
"""A block may seem to come from the future by so much, s; with more its clock is wrong."""

BLOCK_HEADER = struct.Struct("<IId")
"""Number of the block, 0, and when its last sample was heard, ms by the page's clock."""

MIN_PAGE_RATE, MAX_PAGE_RATE = 8_000, 192_000
"""Sample rates of browsers, Hz."""

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
