"""What a room sounds like between what is said in it: followed all the time, in level."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples

Floats = npt.NDArray[np.float64]

FRAME = 480
"""The 30 ms by which the background is followed, as the voice detector does."""

WINDOW, HOP = 320, 160
"""Samples of a spectrum, 20 ms, and between two."""

BANDS = (5, 68, 140)
"""Of a spectrum: 250 to 3,400 Hz, above the hum of motors, and up to 7,000, where the s is."""

SMOOTH = 5
"""Spectra that a level is the mean of."""

MEMORY = 4 * SAMPLE_RATE // FRAME
"""Frames that the background is taken from."""

USUAL = 0.8
"""Of the time it is no louder than the background.

By the half of the time a person who talks in the background stands out of it with each word, and
the clatter of a kitchen too.
"""

SILENT_MEMORY = 8 * SAMPLE_RATE // FRAME
SILENT_SHARE = 0.36
"""Of so many frames without a voice the silence is taken, in a room that is quiet.

Where one command follows the other the room is silent for more of the time. Where somebody talks
on and on it is not, and what stands out of the talk is wanted.
"""

SILENT_USUAL = 0.95
"""Of the silence; the rest is breath, and the ends of words."""

SILENCE = 20.0
"""The level of a quiet room, dB over one unit of the 16 bits."""

DEEP = 20.0
"""By so much silence is below the background, dB, where that was taken from what was said."""

STEADY_FOR = 14
"""Frames, 0.4 s, in which a sound that goes on is known by its level."""

RISE = 6
"""Frames in which something comes up out of what was steady."""


class Noise(NamedTuple):
    """A sound that goes on: its usual levels in both bands, and the highest, dB."""

    usual: Floats
    highest: Floats


class Background:
    """Follows the level of a room, by frames of 30 ms."""

    def __init__(self) -> None:
        """Start with nothing heard, as if it had been silent."""
        self._window = np.hanning(WINDOW + 1)[:-1]
        self._before: Samples = np.zeros(WINDOW - HOP, np.int16)  # what the next spectrum begins in
        self._energies: deque[Floats] = deque(maxlen=SMOOTH)
        self._levels = deque([np.full(2, SILENCE)] * MEMORY, maxlen=SILENT_MEMORY)
        self._voices = deque([False] * MEMORY, maxlen=SILENT_MEMORY)
        self._level_now = SILENCE

    def follow(self, frame: Samples, voice: bool) -> tuple[Floats, Floats]:
        """Take the next frame of the stream.

        Args:
            frame: 30 ms, 16 kHz.
            voice: whether there may be a voice in it.

        Returns:
            Its levels in both bands, and those of the background with it, dB over one unit of the
            16 bits.
        """
        level = self._level(frame)
        self._levels.append(level)
        self._voices.append(voice)
        levels = np.array(self._levels)
        background = _below(levels[-MEMORY:], USUAL)
        silent = levels[~np.array(self._voices)]
        if len(silent) >= SILENT_SHARE * len(levels):
            silence = _below(silent, SILENT_USUAL)
            background = np.where(background - silence > DEEP, silence, background)
        self._level_now = float(background[0])
        return level, background

    @property
    def level(self) -> float:
        """Of the room between 250 and 3,400 Hz now, dB over one unit of the 16 bits."""
        return self._level_now

    @property
    def voices(self) -> float:
        """The share of the last 8 s that a voice may be in."""
        return sum(self._voices) / len(self._voices)

    def remembered(self) -> bytes:
        """All that what follows hangs on."""
        followed = np.array(self._energies).tobytes() + np.array(self._levels).tobytes()
        return self._before.tobytes() + followed + bytes(self._voices)

    def loudest(self, frames: int, but: int) -> float:
        """Find the highest level of the last frames but some, dB; 0 if there are none."""
        end = len(self._levels)
        levels = list(self._levels)[max(0, end - frames) : max(0, end - but)]
        return max((float(low) for low, _ in levels), default=0.0)

    def settle(self, levels: Floats) -> None:
        """Take the levels of a noise that has just begun for the background."""
        self._levels.extend([levels] * SILENT_MEMORY)
        self._voices.extend([True] * SILENT_MEMORY)

    def _level(self, frame: Samples) -> Floats:
        sound = np.concatenate([self._before, frame])
        self._before = frame[HOP - WINDOW :]
        windows = np.lib.stride_tricks.sliding_window_view(sound, WINDOW)[::HOP]
        power = np.abs(np.fft.rfft(windows * self._window)) ** 2
        low, middle, high = BANDS
        bands = np.add.reduceat(power[:, low:high], (0, middle - low), axis=1)
        self._energies.extend(bands / (WINDOW * np.sum(self._window**2)))
        return np.asarray(10 * np.log10(np.mean(self._energies, axis=0) + 1))

    def risen_from(self, by: float, steady_within: float) -> Noise | None:
        """Tell how loud a sound is that goes on, if something rose out of it just now.

        Args:
            by: how far the last two frames are above it, dB.
            steady_within: by how much it may change meanwhile, dB.

        Returns:
            Its usual levels before that, and the highest; None if it was not steady, or nothing
            rose.
        """
        levels = np.array(self._levels)[-STEADY_FOR - RISE :]
        before, now = levels[:STEADY_FOR], levels[-2:]
        steady = _below(before, USUAL)
        rose = np.ptp(before[:, 0]) < steady_within and now[:, 0].min() > steady[0] + by
        return Noise(steady, before.max(axis=0)) if rose else None


def _below(levels: Floats, share: float) -> Floats:
    """The level in each band that so much of them is below."""
    place = int(share * (len(levels) - 1))
    found: Floats = np.partition(levels, place, axis=0)[place]
    return found
