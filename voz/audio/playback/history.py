"""Remembers what the loudspeaker played, and when."""

from __future__ import annotations

import numpy as np

from voz.audio import SAMPLE_RATE
from voz.audio.playback.playing_sound import AUDIBLE_AMPLITUDE, PLAYBACK_RATE, Wave

HISTORY_SAMPLES = 6 * PLAYBACK_RATE
"""6 s: longer than any echo, and any sentence that is compared with it."""

FILTER_MARGIN = PLAYBACK_RATE // 200
"""Samples, 5 ms, on either side of what is resampled, for the filter."""

MAX_DEVICE_DELAY = 0.5
"""A block that is later than this came after silence, s."""

MAX_JITTER = 0.02
"""A larger difference means that the device's delay has changed, s."""

CLOCK_SLEW = 0.05
"""Share of a smaller difference that is corrected; single blocks jitter by some ms."""

DECIMATION = PLAYBACK_RATE // SAMPLE_RATE


class PlaybackHistory:
    """The last seconds of playback by `time.monotonic`, silence in between included."""

    def __init__(self) -> None:
        self._ring: Wave = np.zeros(HISTORY_SAMPLES, np.float32)
        self._count = 0  # samples since the beginning
        self._origin = 0.0  # when the first of them left the loudspeaker
        self._audible = 0  # where the last audible one ended

    @property
    def end(self) -> float:
        """When the last sample is heard, s."""
        return self._origin + self._count / PLAYBACK_RATE

    @property
    def audible_until(self) -> float:
        """When the last audible sample is heard, s."""
        return self._origin + self._audible / PLAYBACK_RATE

    def add(self, block: Wave, time: float) -> None:
        """Add a block, and when its first sample is heard according to the device, s."""
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
        """Return the last seconds before `now`, at most 5.9, to be passed to `to_16_khz`.

        Returns:
            The samples at `PLAYBACK_RATE` with `FILTER_MARGIN` on either side, and when the last
            one before the margin is heard, s.
        """
        end = max(self._count - FILTER_MARGIN, int((now - self._origin) * PLAYBACK_RATE))
        end -= end % DECIMATION  # all calls resample at the same positions
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
    """Resample what `PlaybackHistory.last` returned, and remove its margins."""
    import soxr  # takes 20 ms, and not every run needs it

    margin = FILTER_MARGIN // DECIMATION
    heard: Wave = soxr.resample(cut, PLAYBACK_RATE, SAMPLE_RATE)
    return heard[margin : len(heard) - margin]
