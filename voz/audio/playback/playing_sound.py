"""Several sounds into one: the arithmetic alone, with no device, clock or thread."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Wave: TypeAlias = npt.NDArray[np.float32]
"""Samples of one channel at `PLAYBACK_RATE`, of shape (n,), from -1 to 1 unless said otherwise."""

PLAYBACK_RATE = 48_000
"""Hz. What nearly every loudspeaker takes, and three times what is listened to."""

FADE_SAMPLES = 240
"""Samples, 5 ms: as short as a tone can end without a click."""

AUDIBLE_AMPLITUDE = 0.004
"""-48 dB. festival's silence stays below it."""

GAIN_RECOVERY = 1 / PLAYBACK_RATE
"""How fast the gain comes back after it was too loud, for each sample: from 0 to 1 in a second."""


class PlayingSound:
    """A sound on its way out: where it is, how loud, and whether it begins again at its end."""

    def __init__(self, sound: Wave, volume: float = 1.0, repeats: bool = False) -> None:
        """Start at the beginning.

        Args:
            sound: at least one sample.
            volume: its amplitude is multiplied by this, 0 to 1.
            repeats: whether it goes on until it is stopped.
        """
        self.repeats = repeats
        self._sound = sound
        self._volume = volume
        self._position = 0
        self._fade_left: int | None = None
        (audible,) = np.nonzero(np.abs(sound) * volume > AUDIBLE_AMPLITUDE)
        self._audible_end = int(audible[-1]) + 1 if len(audible) else 0

    @property
    def begun(self) -> bool:
        """Whether any of it was taken."""
        return self._position > 0

    @property
    def over(self) -> bool:
        """Whether only silence would follow."""
        if self._fade_left is not None and self._fade_left <= 0:
            return True
        return not self.repeats and self._position >= len(self._sound)

    @property
    def audible_left(self) -> float:
        """How many samples from now on the last audible one is; infinity if it repeats."""
        if self._fade_left is not None:
            return max(0, self._fade_left)
        if self.repeats:
            return math.inf if self._audible_end else 0
        return max(0, self._audible_end - self._position)

    def stop(self) -> None:
        """Let it fade out from here on; what was never begun is over at once."""
        if self._fade_left is None:
            self._fade_left = FADE_SAMPLES if self.begun else 0

    def drop(self) -> None:
        """Be over at once, unheard."""
        self._fade_left = 0

    def take(self, frames: int) -> Wave:
        """Give the next samples, silence after its end."""
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
    """Add up the next samples of all sources, and turn the sum down where it is too loud.

    Args:
        sources: what sounds at once; each goes on by `frames`.
        frames: how many samples.
        gain: what the call before returned.

    Returns:
        The samples, none beyond -1 and 1, and the gain that was reached: below 1 if the sum
        was too loud a short time ago.
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
    """Leave out the silence that a sound begins with.

    Args:
        sound: may be silent altogether: then it stays as it is.
        before: how much of the silence is kept, samples.
    """
    start = int(np.argmax(np.abs(sound) > AUDIBLE_AMPLITUDE))
    return sound[max(0, start - before) :]
