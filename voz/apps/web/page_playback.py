"""What the driving page plays: meanwhile a microphone listens only for what must not be missed."""

from __future__ import annotations

import time

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE
from voz.hearing.half_duplex import Playback

MAX_PLAYBACK = 30.0
"""The longest sound that a page may play, s: no recording is longer."""

PLAYBACK_DELAY = 1.0
"""A page may begin so much later than it says, s: wireless loudspeakers take a third of it."""


class PagePlayback:
    """The robot's own playback, and that of the driving page, of which only the end is known.

    The server's thread calls `start`, the microphone's thread the others.

    Attributes:
        robot: the robot's own playback, if it has any.
    """

    def __init__(self) -> None:
        self.robot: Playback | None = None
        self._until = 0.0  # on the monotonic clock, s

    def start(self, seconds: float) -> None:
        """Note that a page plays for so long, in place of what it played before."""
        self._until = time.monotonic() + seconds + PLAYBACK_DELAY

    def busy_until(self) -> float:
        """When the last of it has left a loudspeaker, on the monotonic clock, s."""
        return max(self._until, self.robot.busy_until() if self.robot else 0.0)

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        """What the robot played last; a page's sound cannot be subtracted."""
        if self.robot:
            return self.robot.recent(seconds)
        return np.zeros(round(seconds * SAMPLE_RATE), np.float32), time.monotonic()
