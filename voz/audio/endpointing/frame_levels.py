"""Measures the level of each frame in two bands, many frames at once."""

from __future__ import annotations

from itertools import zip_longest
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples

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

    def state(self) -> bytes:
        """Return everything that the levels of later frames depend on."""
        return self._before.tobytes() + self._energies.tobytes()

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
