"""What a room sounds like between what is said in it: followed all the time, in level."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples

Floats = npt.NDArray[np.float64]

FRAME = 480
"""The 30 ms by which the background is followed, as the voice detector does."""

WINDOW, HOP = 320, 160
"""Samples of a spectrum, 20 ms, and between two."""

WINDOWS = np.arange(WINDOW) + HOP * np.arange(FRAME // HOP)[:, np.newaxis]
"""Where the spectra of a frame are, in the sound that begins a hop before it."""

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

ROOM = 4096
"""Frames that there is room for before the last ones are moved to the beginning."""

STEADY_FOR = 14
"""Frames, 0.4 s, in which a sound that goes on is known by its level."""

RISE = 6
"""Frames in which something comes up out of what was steady."""


class Noise(NamedTuple):
    """A sound that goes on: its usual levels in both bands, and the highest, dB."""

    usual: Floats
    highest: Floats


class _Recent:
    """The last levels of frames, in one array: to make one of them for each frame takes longer.

    Attributes:
        levels: of each frame, in both bands, dB.
        voices: whether a voice may be in it.
    """

    def __init__(self) -> None:
        """Start as if it had been silent."""
        self._levels = np.full((ROOM, 2), SILENCE)
        self._voices = np.zeros(ROOM, np.bool_)
        self._end = MEMORY

    def add(self, level: Floats, voice: bool) -> None:
        """Add a frame; the oldest goes."""
        if self._end == ROOM:
            self._levels[:SILENT_MEMORY] = self.levels
            self._voices[:SILENT_MEMORY] = self.voices
            self._end = SILENT_MEMORY
        self._levels[self._end], self._voices[self._end] = level, voice
        self._end += 1

    def fill(self, level: Floats, voice: bool) -> None:
        """Take all of them for such ones."""
        self._levels[:SILENT_MEMORY], self._voices[:SILENT_MEMORY] = level, voice
        self._end = SILENT_MEMORY

    @property
    def levels(self) -> Floats:
        return self._levels[max(0, self._end - SILENT_MEMORY) : self._end]

    @property
    def voices(self) -> npt.NDArray[np.bool_]:
        return self._voices[max(0, self._end - SILENT_MEMORY) : self._end]


class Background:
    """Follows the level of a room, by frames of 30 ms."""

    def __init__(self) -> None:
        """Start with nothing heard, as if it had been silent."""
        self._window = np.hanning(WINDOW + 1)[:-1]
        self._before: Samples = np.zeros(WINDOW - HOP, np.int16)  # what the next spectrum begins in
        self._scale = WINDOW * np.sum(self._window**2)
        self._energies: Floats = np.empty((0, len(BANDS) - 1))
        self._recent = _Recent()
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
        self._recent.add(level, voice)
        levels = self._recent.levels
        background = _below(levels[-MEMORY:], USUAL)
        silent = levels[~self._recent.voices]
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
        voices = self._recent.voices
        return int(voices.sum()) / len(voices)

    def remembered(self) -> bytes:
        """All that what follows hangs on."""
        followed = self._energies.tobytes() + self._recent.levels.tobytes()
        return self._before.tobytes() + followed + self._recent.voices.tobytes()

    def loudest(self, frames: int, but: int) -> float:
        """Find the highest level of the last frames but some, dB; 0 if there are none."""
        levels = self._recent.levels
        end = len(levels)
        found = levels[max(0, end - frames) : max(0, end - but), 0]
        return float(found.max()) if len(found) else 0.0

    def settle(self, levels: Floats) -> None:
        """Take the levels of a noise that has just begun for the background."""
        self._recent.fill(levels, True)

    def _level(self, frame: Samples) -> Floats:
        sound = np.concatenate([self._before, frame])
        self._before = frame[HOP - WINDOW :]
        power = np.abs(np.fft.rfft(sound[WINDOWS] * self._window)) ** 2
        low, middle, high = BANDS
        bands = np.add.reduceat(power[:, low:high], (0, middle - low), axis=1)
        self._energies = np.concatenate([self._energies, bands / self._scale])[-SMOOTH:]
        return np.asarray(10 * np.log10(self._energies.mean(axis=0) + 1))

    def risen_from(self, by: float, steady_within: float) -> Noise | None:
        """Tell how loud a sound is that goes on, if something rose out of it just now.

        Args:
            by: how far the last two frames are above it, dB.
            steady_within: by how much it may change meanwhile, dB.

        Returns:
            Its usual levels before that, and the highest; None if it was not steady, or nothing
            rose.
        """
        levels = self._recent.levels[-STEADY_FOR - RISE :]
        before, now = levels[:STEADY_FOR], levels[-2:]
        steady = _below(before, USUAL)
        rose = np.ptp(before[:, 0]) < steady_within and now[:, 0].min() > steady[0] + by
        return Noise(steady, before.max(axis=0)) if rose else None


def _below(levels: Floats, share: float) -> Floats:
    """The level in each band that so much of them is below."""
    place = int(share * (len(levels) - 1))
    found: Floats = np.partition(levels, place, axis=0)[place]
    return found
