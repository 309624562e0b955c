"""Levels of sound: of each frame in two bands, and of the room between utterances."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples


def quantile(values: npt.ArrayLike, share: float) -> Any:
    """The value that a share (0 to 1) of some values is below, interpolated as numpy does it.

    numpy's own function loads the 5 MB of `numpy.ma`. Of more than one dimension it is taken along
    the first; there must be at least one value.
    """
    ordered = np.sort(np.asarray(values, np.float64), axis=0)
    place = share * (len(ordered) - 1)
    below = ordered[int(place)]
    above = ordered[min(int(place) + 1, len(ordered) - 1)]
    return below + (above - below) * (place - int(place))


Floats = npt.NDArray[np.float64]

BandLevels: TypeAlias = tuple[float, float]
"""Of a frame, in both bands, dB relative to one unit of the 16 bits."""

FRAME = 480
"""Samples of a frame, 30 ms, as WebRTC's voice detector takes them."""

SPECTRUM_WINDOW, SPECTRUM_HOP = 320, 160
"""Samples of a spectrum, 20 ms, and between two."""

SPECTRA_PER_FRAME = FRAME // SPECTRUM_HOP

BAND_EDGES = (5, 68, 140)
"""Bins: 250 to 3,400 Hz, above the hum of motors, and from there to 7,000, where the s is."""

SMOOTHED_SPECTRA = 5
"""Spectra that a level is the mean of."""

BATCH_FRAMES = 10 * SAMPLE_RATE // FRAME
"""Frames whose spectra are computed together; those of an hour would take a gigabyte."""


class LevelMeter:
    """Measures a stream; the size of its blocks makes no difference."""

    def __init__(self) -> None:
        """Start a stream."""
        self._window = np.hanning(SPECTRUM_WINDOW + 1)[:-1]
        self._scale = SPECTRUM_WINDOW * np.sum(self._window**2)
        self._before: Samples = np.zeros(
            SPECTRUM_WINDOW - SPECTRUM_HOP, np.int16
        )  # the next spectrum begins in it
        self._energies: Floats = np.empty((0, len(BAND_EDGES) - 1))

    def measure(self, sound: Samples) -> list[BandLevels]:
        """Measure the next frames of the stream; `sound` is whole frames, 16 kHz."""
        some = BATCH_FRAMES * FRAME
        first = some if len(self._energies) else FRAME  # the first frame has fewer spectra
        begins = [0, *range(first, len(sound), some)]
        pieces = (sound[at:end] for at, end in zip_longest(begins, begins[1:]))
        return [level for piece in pieces for level in self._measure_batch(piece)]

    def _measure_batch(self, sound: Samples) -> list[BandLevels]:
        count = len(sound) // FRAME
        if not count:
            return []
        energies = np.concatenate([self._energies, self._bands(sound)])
        self._energies = energies[-SMOOTHED_SPECTRA:]
        found = 10 * np.log10(_means(energies, count) + 1)
        return [(low, high) for low, high in found.tolist()]

    def _bands(self, sound: Samples) -> Floats:
        """Return the energy in each band, of shape (spectra, bands)."""
        sound = np.concatenate([self._before, sound])
        self._before = sound[len(sound) - (SPECTRUM_WINDOW - SPECTRUM_HOP) :]
        windows = np.lib.stride_tricks.sliding_window_view(sound, SPECTRUM_WINDOW)[::SPECTRUM_HOP]
        power = np.abs(np.fft.rfft(windows * self._window)) ** 2
        low, middle, high = BAND_EDGES
        bands: Floats = np.add.reduceat(power[:, low:high], (0, middle - low), axis=1)
        bands /= self._scale
        return bands


def _means(energies: Floats, count: int) -> Floats:
    end = len(energies) - SPECTRA_PER_FRAME * (count - 1)  # of the first frame
    smooth = min(SMOOTHED_SPECTRA, end)
    # Added in the same order as for a single frame.
    spectra = [energies[end - place :: SPECTRA_PER_FRAME][:count] for place in range(smooth, 0, -1)]
    means: Floats = sum(spectra[1:], spectra[0]) / smooth
    return means


BACKGROUND_FRAMES = 4 * SAMPLE_RATE // FRAME
"""Frames that the background is taken from, 4 s."""

BACKGROUND_QUANTILE = 0.8
"""Quantile of the levels; by the median each word of background talk would stand out."""

SILENCE_FRAMES = 8 * SAMPLE_RATE // FRAME
MIN_SILENT_SHARE = 0.36
"""Of the last `SILENCE_FRAMES`: if more have no voice, the background is taken from these.

So commands in quick succession are not taken for the background, and long talk is.
"""

SILENCE_QUANTILE = 0.95
"""Quantile of the frames without a voice; louder ones are breath, and ends of words."""

QUIET_ROOM_LEVEL = 20.0
"""Level of a quiet room, dB relative to one unit of the 16 bits."""

MIN_SILENCE_DEPTH = 8.0
"""Silence this far below the background replaces it, dB.

With 20 a long sentence in noise became the background, and what came after a breath was lost.
"""

MAX_KEPT_FRAMES = 4096
"""Frames that are kept before all but the last ones are deleted."""

STEADY_FRAMES = 14
"""Frames, 0.4 s, whose level must be steady in a noise."""

RISE_FRAMES = 6
"""Frames in which speech rises above a noise."""


@dataclass(frozen=True)
class SteadyNoise:
    """A noise: its usual and its highest levels in both bands, dB."""

    usual: BandLevels
    highest: BandLevels


class _SortedLevels:
    """The levels of some frames, sorted in each band."""

    def __init__(self, levels: Iterable[BandLevels]) -> None:
        self._bands = [sorted(band) for band in zip(*levels, strict=True)] or [[], []]

    def __len__(self) -> int:
        return len(self._bands[0])

    def add(self, level: BandLevels) -> None:
        for band, value in zip(self._bands, level, strict=True):
            insort(band, value)

    def drop(self, level: BandLevels) -> None:
        for band, value in zip(self._bands, level, strict=True):
            del band[bisect_left(band, value)]

    def quantile(self, share: float) -> BandLevels:
        low, high = self._bands
        place = int(share * (len(low) - 1))
        return low[place], high[place]


class Background:
    """Follows the level of a room, frame by frame."""

    def __init__(self) -> None:
        """Start as if the room had been quiet."""
        self._fill((QUIET_ROOM_LEVEL, QUIET_ROOM_LEVEL), False, BACKGROUND_FRAMES)
        self._level_now = QUIET_ROOM_LEVEL

    def follow(self, level: BandLevels, voice: bool) -> BandLevels:
        """Take the level of the next frame, and whether a voice may be in it.

        Returns the levels of the background, this frame included.
        """
        self._add(level, voice)
        low, high = self._recent.quantile(BACKGROUND_QUANTILE)
        if len(self._silent) >= MIN_SILENT_SHARE * min(len(self._levels), SILENCE_FRAMES):
            least_low, least_high = self._silent.quantile(SILENCE_QUANTILE)
            low = least_low if low - least_low > MIN_SILENCE_DEPTH else low
            high = least_high if high - least_high > MIN_SILENCE_DEPTH else high
        self._level_now = low
        return low, high

    @property
    def level(self) -> float:
        """Level of the room now, 250 to 3,400 Hz, dB relative to one unit of the 16 bits."""
        return self._level_now

    @property
    def voices(self) -> float:
        """Share of the last 8 s that a voice may be in."""
        voices = self._voices[-SILENCE_FRAMES:]
        return sum(voices) / len(voices)

    def loudest(self, frames: int, but: int) -> float:
        """Highest level of the last `frames` without the last `but`, dB; 0 if there are none."""
        frames = min(frames, SILENCE_FRAMES)
        end = len(self._levels)
        found = self._levels[max(0, end - frames) : max(0, end - but)]
        return max((low for low, _ in found), default=0.0)

    def settle(self, level: BandLevels) -> None:
        """Take a noise that has just begun as the background."""
        self._fill(level, True, SILENCE_FRAMES)

    def risen_above(self, by: float, steady_within: float) -> SteadyNoise | None:
        """Find the steady noise that the last two frames have just risen above by so much, dB.

        None if its level changed by more than `steady_within`, dB, or nothing rose.
        """
        last = self._levels[-STEADY_FRAMES - RISE_FRAMES :]
        before, now = last[:STEADY_FRAMES], last[-2:]
        lows = [low for low, _ in before]
        if max(lows) - min(lows) >= steady_within:
            return None
        steady = _SortedLevels(before).quantile(BACKGROUND_QUANTILE)
        if min(low for low, _ in now) <= steady[0] + by:
            return None
        return SteadyNoise(steady, (max(lows), max(high for _, high in before)))

    def _add(self, level: BandLevels, voice: bool) -> None:
        self._recent.drop(self._levels[-BACKGROUND_FRAMES])
        self._recent.add(level)
        if len(self._levels) >= SILENCE_FRAMES and not self._voices[-SILENCE_FRAMES]:
            self._silent.drop(self._levels[-SILENCE_FRAMES])
        if not voice:
            self._silent.add(level)
        self._levels.append(level)
        self._voices.append(voice)
        if len(self._levels) > MAX_KEPT_FRAMES:
            del self._levels[:-SILENCE_FRAMES], self._voices[:-SILENCE_FRAMES]

    def _fill(self, level: BandLevels, voice: bool, count: int) -> None:
        self._levels, self._voices = [level] * count, [voice] * count
        self._recent = _SortedLevels(self._levels[-BACKGROUND_FRAMES:])
        self._silent = _SortedLevels([] if voice else self._levels)
