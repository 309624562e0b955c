"""What the loudspeaker gave out and when: for who listens beside it. Time comes in as arguments."""

from __future__ import annotations

import numpy as np

from voz.audio import SAMPLE_RATE
from voz.audio.playback.playing_sound import AUDIBLE_AMPLITUDE, PLAYBACK_RATE, Wave

HISTORY_SAMPLES = 6 * PLAYBACK_RATE
"""Samples, 6 s: longer than any echo and any sentence that is compared with it."""

FILTER_MARGIN = PLAYBACK_RATE // 200
"""Samples, 5 ms, either side of what is resampled: there the filter would feel the cut."""

MAX_DEVICE_DELAY = 0.5
"""Seconds. A block that comes later than this was preceded by silence: no device delays so long."""

MAX_JITTER = 0.02
"""Seconds. Where a block differs by more, the device's delay has changed, as it does at first."""

CLOCK_SLEW = 0.05
"""How much of a smaller difference is believed: the time of a single block trembles by some ms."""

DECIMATION = PLAYBACK_RATE // SAMPLE_RATE


class PlaybackHistory:
    """The last seconds on the clock of `time.monotonic`, silence in between included."""

    def __init__(self) -> None:
        self._ring: Wave = np.zeros(HISTORY_SAMPLES, np.float32)
        self._count = 0  # samples since the beginning
        self._origin = 0.0  # when the first of them left the loudspeaker
        self._audible = 0  # where the last audible one ended

    @property
    def end(self) -> float:
        """When the last sample leaves the loudspeaker, s."""
        return self._origin + self._count / PLAYBACK_RATE

    @property
    def audible_until(self) -> float:
        """When the last audible sample leaves the loudspeaker, s."""
        return self._origin + self._audible / PLAYBACK_RATE

    def add(self, block: Wave, time: float) -> None:
        """Take what is given out next.

        Args:
            block: the samples.
            time: when the first one leaves the loudspeaker, s, as the device tells it.
        """
        difference = time - self.end
        if difference > MAX_DEVICE_DELAY:
            missing = round(difference * PLAYBACK_RATE)
            self._write(np.zeros(min(HISTORY_SAMPLES, missing), np.float32))
            self._count += missing - min(HISTORY_SAMPLES, missing)
        else:
            self._origin += difference if abs(difference) > MAX_JITTER else CLOCK_SLEW * difference
        (audible,) = np.nonzero(np.abs(block) > AUDIBLE_AMPLITUDE)
        if len(audible):
            self._audible = self._count + int(audible[-1]) + 1
        self._write(block)

    def last(self, seconds: float, now: float) -> tuple[Wave, float]:
        """Cut out what was heard last, to be given to `to_16_khz`.

        Args:
            seconds: how long, up to 5.9.
            now: the time, s; if the last block ended before, the rest up to now is silence.

        Returns:
            The samples at `PLAYBACK_RATE` with `FILTER_MARGIN` on either side, and when the last
            one before the margin leaves the loudspeaker, s.
        """
        end = max(self._count - FILTER_MARGIN, int((now - self._origin) * PLAYBACK_RATE))
        end -= end % DECIMATION  # so that the samples of all calls stand at the same places
        start = end - round(seconds * SAMPLE_RATE) * DECIMATION
        places = np.arange(start - FILTER_MARGIN, end + FILTER_MARGIN)
        known = (places < self._count) & (places >= max(0, self._count - HISTORY_SAMPLES))
        return self._ring[places % HISTORY_SAMPLES] * known, self._origin + (
            end - DECIMATION
        ) / PLAYBACK_RATE

    def _write(self, block: Wave) -> None:
        self._ring[np.arange(self._count, self._count + len(block)) % HISTORY_SAMPLES] = block
        self._count += len(block)


def to_16_khz(cut: Wave) -> Wave:
    """Bring what `History.last` cut out to the rate of the recognizer, 16 kHz."""
    import soxr  # 20 ms that who never asks need not wait for

    margin = FILTER_MARGIN // DECIMATION
    heard: Wave = soxr.resample(cut, PLAYBACK_RATE, SAMPLE_RATE)
    return heard[margin : len(heard) - margin]
