"""What the loudspeaker gave out and when: for who listens beside it. Time comes in as arguments."""

from __future__ import annotations

import numpy as np

from voz.audio import SAMPLE_RATE
from voz.audio.playback.mixing import AUDIBLE, RATE, Wave

KEPT = 6 * RATE
"""Samples, 6 s: longer than any echo and any sentence that is compared with it."""

MARGIN = RATE // 200
"""Samples, 5 ms, either side of what is resampled: there the filter would feel the cut."""

INTERRUPTION = 0.5
"""Seconds. A block that comes later than this was preceded by silence: no device delays so long."""

JUMP = 0.02
"""Seconds. Where a block differs by more, the device's delay has changed, as it does at first."""

SLEW = 0.05
"""How much of a smaller difference is believed: the time of a single block trembles by some ms."""

STEP = RATE // SAMPLE_RATE


class History:
    """The last seconds on the clock of `time.monotonic`, silence in between included."""

    def __init__(self) -> None:
        self._ring: Wave = np.zeros(KEPT, np.float32)
        self._count = 0  # samples since the beginning
        self._origin = 0.0  # when the first of them left the loudspeaker
        self._audible = 0  # where the last audible one ended

    @property
    def end(self) -> float:
        """When the last sample leaves the loudspeaker, s."""
        return self._origin + self._count / RATE

    @property
    def audible_until(self) -> float:
        """When the last audible sample leaves the loudspeaker, s."""
        return self._origin + self._audible / RATE

    def add(self, block: Wave, time: float) -> None:
        """Take what is given out next.

        Args:
            block: the samples.
            time: when the first one leaves the loudspeaker, s, as the device tells it.
        """
        difference = time - self.end
        if difference > INTERRUPTION:
            missing = round(difference * RATE)
            self._write(np.zeros(min(KEPT, missing), np.float32))
            self._count += missing - min(KEPT, missing)
        else:
            self._origin += difference if abs(difference) > JUMP else SLEW * difference
        (audible,) = np.nonzero(np.abs(block) > AUDIBLE)
        if len(audible):
            self._audible = self._count + int(audible[-1]) + 1
        self._write(block)

    def last(self, seconds: float, now: float) -> tuple[Wave, float]:
        """Cut out what was heard last, to be given to `to_heard`.

        Args:
            seconds: how long, up to 5.9.
            now: the time, s; if the last block ended before, the rest up to now is silence.

        Returns:
            The samples at `RATE` with `MARGIN` either side, and when the last one before the
            margin leaves the loudspeaker, s.
        """
        end = max(self._count - MARGIN, int((now - self._origin) * RATE))
        end -= end % STEP  # so that the samples of all calls stand at the same places
        start = end - round(seconds * SAMPLE_RATE) * STEP
        places = np.arange(start - MARGIN, end + MARGIN)
        known = (places < self._count) & (places >= max(0, self._count - KEPT))
        return self._ring[places % KEPT] * known, self._origin + (end - STEP) / RATE

    def _write(self, block: Wave) -> None:
        self._ring[np.arange(self._count, self._count + len(block)) % KEPT] = block
        self._count += len(block)


def to_heard(cut: Wave) -> Wave:
    """Bring what `History.last` cut out to the rate of the recognizer, 16 kHz."""
    import soxr  # 20 ms that who never asks need not wait for

    margin = MARGIN // STEP
    heard: Wave = soxr.resample(cut, RATE, SAMPLE_RATE)
    return heard[margin : len(heard) - margin]
