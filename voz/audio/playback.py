"""Sounds that play, mixed, and what was played when: without device, clock or thread."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE

Wave: TypeAlias = npt.NDArray[np.float32]
"""Samples of one channel at `PLAYBACK_RATE`, of shape (n,), -1 to 1 unless said otherwise."""

PLAYBACK_RATE = 48_000
"""Hz; nearly every loudspeaker takes it, and it is three times the recognizer's."""

FADE_SAMPLES = 240
"""5 ms: as short as a tone can end without a click."""

AUDIBLE_AMPLITUDE = 0.004
"""-48 dB; festival's silence is below it."""

GAIN_RECOVERY = 1 / PLAYBACK_RATE
"""Rise of the gain for each sample after it was turned down: from 0 to 1 in a second."""


class PlayingSound:
    """A sound that is playing: its position, volume and fade."""

    def __init__(
        self, sound: Wave, volume: float = 1.0, repeats: bool = False, text: str | None = None
    ) -> None:
        """Start at the beginning of a sound of one sample or more; the volume is 0 to 1.

        The text is None if it is no speech, or its words are not known.
        """
        self.repeats = repeats
        self.text = text
        self._sound = sound
        self._volume = volume
        self._position = 0
        self._fade_left: int | None = None
        (audible,) = np.nonzero(np.abs(sound) * volume > AUDIBLE_AMPLITUDE)
        self._audible_end = int(audible[-1]) + 1 if len(audible) else 0

    @property
    def begun(self) -> bool:
        """Whether any samples were taken."""
        return self._position > 0

    @property
    def over(self) -> bool:
        """Whether only silence would follow."""
        if self._fade_left is not None and self._fade_left <= 0:
            return True
        return not self.repeats and self._position >= len(self._sound)

    @property
    def audible_left(self) -> float:
        """Samples until the last audible one; infinite if it repeats."""
        if self._fade_left is not None:
            return max(0, self._fade_left)
        if self.repeats:
            return math.inf if self._audible_end else 0
        return max(0, self._audible_end - self._position)

    def stop(self) -> None:
        """Fade out from here; a sound that has not begun is over at once."""
        if self._fade_left is None:
            self._fade_left = FADE_SAMPLES if self.begun else 0

    def drop(self) -> None:
        """End at once, without a fade."""
        self._fade_left = 0

    def take(self, frames: int) -> Wave:
        """Return the next samples, and silence after the end."""
        end = self._position + frames
        if self.repeats:
            block: Wave = self._sound[np.arange(self._position, end) % len(self._sound)]
            self._position = end % len(self._sound) or len(self._sound)
        else:
            block = np.zeros(frames, np.float32)
            part = self._sound[self._position : end]
            block[: len(part)] = part
            self._position = end
        block *= np.float32(self._volume)
        if self._fade_left is not None:
            left = self._fade_left - np.arange(frames, dtype=np.float32)
            block *= np.sin(np.clip(left / FADE_SAMPLES, 0, 1) * (math.pi / 2)) ** 2
            self._fade_left -= frames
        return block


def mix(sources: Sequence[PlayingSound], frames: int, gain: float = 1.0) -> tuple[Wave, float]:
    """Add up the next samples of all sounds, turned down where the sum is too loud.

    The gain comes from the call before. Returns the samples, -1 to 1, and the gain at their end.
    """
    total = np.zeros(frames, np.float32)
    for source in sources:
        total += source.take(frames)
    peak = float(np.abs(total).max(initial=0.0))
    reached = min(1.0, gain + frames * GAIN_RECOVERY, 1 / max(peak, 1.0))
    if gain < 1.0 or reached < 1.0:
        total *= np.linspace(gain, reached, frames + 1, dtype=np.float32)[1:]
    return np.clip(total, -1.0, 1.0, out=total), reached


def trim_leading_silence(sound: Wave, before: int = PLAYBACK_RATE // 100) -> Wave:
    """Remove all but `before` samples of the leading silence, if the sound is not all silent."""
    start = int(np.argmax(np.abs(sound) > AUDIBLE_AMPLITUDE))
    return sound[max(0, start - before) :]


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
