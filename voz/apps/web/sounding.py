"""What pages play beside a microphone: while they do, only what must not be missed is heard."""

from __future__ import annotations

import time

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE
from voz.hearing.half_duplex import Playback

LONGEST = 30.0
"""A page plays nothing longer, s: no recording is."""

SLOW = 1.0
"""By so much later than it says a page may begin, s: loudspeakers by radio take a third of it."""


class Sounding:
    """The robot's own sound, and what the page that drives plays; nobody knows the latter exactly.

    The server's thread says that a page plays, the thread that listens asks.
    """

    def __init__(self) -> None:
        self._own: Playback | None = None
        self._until = 0.0  # on the monotonic clock, s

    def beside(self, own: Playback | None) -> Playback:
        """Tell of the robot's own sound, too."""
        self._own = own
        return self

    def begin(self, seconds: float) -> None:
        """Note that a page plays something of so many seconds, in place of what it did before."""
        self._until = time.monotonic() + seconds + SLOW

    def busy_until(self) -> float:
        """When the last of it has left a loudspeaker, on the monotonic clock, s."""
        return max(self._until, self._own.busy_until() if self._own else 0.0)

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        """What the robot gave out last; of a page's sound nothing can be taken away."""
        if self._own:
            return self._own.recent(seconds)
        return np.zeros(round(seconds * SAMPLE_RATE), np.float32), time.monotonic()
