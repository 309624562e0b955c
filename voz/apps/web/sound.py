"""What a page sends of its microphone: blocks with a number and a time. Pure."""

from __future__ import annotations

import struct
from collections import deque
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

OLDEST = 0.3
"""Sound that is older when it arrives is left out, s: a late `forward` must never drive."""

AHEAD = 0.1
"""By so much a block may seem to come from the future, s; beyond it its clock is wrong."""

HEADER = struct.Struct("<IId")
"""Number of the block, 0, and when its last sample was heard, ms by the page's clock."""

LOWEST_RATE, HIGHEST_RATE = 8_000, 192_000
"""Of the sound, Hz."""

MOST_SAMPLES = 9_600
"""In a block: 0.1 s at 96 kHz."""

KEPT = 8
"""Answers from which the two clocks are compared."""


class Block(NamedTuple):
    """A block of sound: its number, when it was heard (ms), and floats from -1 to 1."""

    number: int
    heard: float
    sound: npt.NDArray[np.float32]


def read_block(data: bytes) -> Block | None:
    """Read a block as the page sends it, 16-bit samples after a header; None if it is none."""
    samples, odd = divmod(len(data) - HEADER.size, 2)
    if odd or not 0 < samples <= MOST_SAMPLES:
        return None
    number, zero, heard = HEADER.unpack_from(data)
    if zero or not np.isfinite(heard):
        return None
    sound = np.frombuffer(data, "<i2", offset=HEADER.size).astype(np.float32) / np.float32(32768)
    return Block(number, heard, sound)


class PageClock:
    """The time of a page beside that of this computer: by questions that it answers at once."""

    def __init__(self) -> None:
        self._answers: deque[tuple[float, float]] = deque(maxlen=KEPT)  # the way there and back, s

    @property
    def known(self) -> bool:
        """Whether there is an answer yet."""
        return bool(self._answers)

    def answered(self, asked: float, now: float, page: float) -> None:
        """Take an answer.

        Args:
            asked: when the question was sent, s.
            now: when the answer arrived, s.
            page: the page's time in between, s.
        """
        # The shorter the way, the less can be wrong.
        self._answers.append((now - asked, page - (now + asked) / 2))

    def age(self, heard: float, now: float) -> float:
        """Tell how old sound is, s.

        Args:
            heard: when it was heard by the page's clock, s.
            now: the time here, s.
        """
        _, ahead = min(self._answers)
        return now - (heard - ahead)
