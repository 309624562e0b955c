"""A Wiener filter for noisy stretches of speech."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.levels import quantile

Floats = npt.NDArray[np.float64]

ENERGY_FRAME = SAMPLE_RATE // 100
"""Samples in 10 ms, over which the energy is measured."""

MAX_NOISY_RANGE = 25.0
"""Speech whose frame energies span less than this is filtered, dB: filtering all loses commands."""

WIENER_WINDOW, WIENER_HOP = 512, 128  # samples, 32 and 8 ms
NOISE_QUANTILE = 0.4  # of the time a band has only noise
POWER_SMOOTHING = 0.7  # for each frame, of the power that the noise is taken from
PRIOR_SNR_WEIGHT = 0.92  # of the decision-directed signal-to-noise ratio
MIN_GAIN = 0.2
"""Of a band; with less the filtered speech sounds like nothing the acoustic model knows."""


def frame_energies(samples: Samples | Floats) -> Floats:
    """Return the mean square of each whole 10 ms, dB relative to one unit of the 16 bits."""
    whole = samples[: len(samples) // ENERGY_FRAME * ENERGY_FRAME]
    frames = whole.astype(np.float64).reshape(-1, ENERGY_FRAME)
    return np.asarray(10 * np.log10((frames**2).mean(axis=1) + 1))


def is_noisy(samples: Samples) -> bool:
    """Whether a stretch of speech, with a margin on either side, has noise in it."""
    found = frame_energies(samples)
    if not len(found):
        return False
    return bool(quantile(found, 0.95) - quantile(found, 0.1) < MAX_NOISY_RANGE)


def denoise_if_noisy(samples: Samples) -> Samples:
    """Denoise a stretch of speech, 16 kHz, if it is noisy; else return the same array."""
    return denoise(samples) if is_noisy(samples) else samples


def denoise(samples: Samples) -> Samples:
    """Filter out steady noise; returns as many samples, 16 kHz.

    The noise of a band is a low quantile of its smoothed power. The signal-to-noise ratio is
    estimated decision-directed (Ephraim and Malah 1984, doi:10.1109/TASSP.1984.1164453).
    """
    # A periodic window, whose square adds up to the same everywhere.
    window = np.sqrt(np.hanning(WIENER_WINDOW + 1)[:-1])
    padded = np.pad(samples.astype(np.float64), (WIENER_WINDOW, WIENER_WINDOW + WIENER_HOP))
    frames = np.lib.stride_tricks.sliding_window_view(padded, WIENER_WINDOW)[::WIENER_HOP]
    spectra = np.fft.rfft(frames * window, axis=1)
    filtered = np.fft.irfft(spectra * _gains(np.abs(spectra) ** 2), axis=1) * window
    sound = np.zeros(len(padded))
    for number, frame in enumerate(filtered):
        sound[number * WIENER_HOP : number * WIENER_HOP + WIENER_WINDOW] += frame
    sound /= np.sum(window**2) / WIENER_HOP
    kept = sound[WIENER_WINDOW : WIENER_WINDOW + len(samples)]
    return np.clip(np.round(kept), -32768, 32767).astype(np.int16)


def _gains(power: Floats) -> Floats:
    """Return the share of speech in each band of each frame; `power` is (n, bands)."""
    noise = quantile(_smooth(power), NOISE_QUANTILE) + 1e-9
    above = power / noise
    before = np.maximum(above[0] - 1, 0)
    gains: Floats = np.empty_like(power)
    for number, ratio in enumerate(above):
        speech = PRIOR_SNR_WEIGHT * before + (1 - PRIOR_SNR_WEIGHT) * np.maximum(ratio - 1, 0)
        gains[number] = np.maximum(speech / (1 + speech), MIN_GAIN)
        before = gains[number] ** 2 * ratio
    return gains


def _smooth(power: Floats) -> Floats:
    smooth: Floats = power.copy()
    for number in range(1, len(power)):
        smooth[number] = (
            POWER_SMOOTHING * smooth[number - 1] + (1 - POWER_SMOOTHING) * power[number]
        )
    return smooth
