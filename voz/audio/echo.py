"""Echo cancellation: removes from the microphone's sound what the loudspeaker played.

In each frequency band the echo is a weighted sum of the last played frames; the weights are fitted
by least squares to one window (convolutive transfer function, Talmon, Cohen and Gannot 2009).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples
from voz.process.one_thread import on_one_thread

Floats: TypeAlias = npt.NDArray[np.float64]
Spectrum: TypeAlias = npt.NDArray[np.complex128]

ECHO_WINDOW = 512
ECHO_HOP = 256

ECHO_EDGE = ECHO_WINDOW - ECHO_HOP
"""Samples at either end that are incomplete: some of their windows lie outside."""

ROOM_TAPS = 12
"""Frames of the past that the room reflects, 0.2 s."""

LEAD_TAPS = 1
"""Frames by which the estimated delay may be too long."""

RELATIVE_RIDGE = 1e-3
"""Of the mean power, added to the diagonal so that silence gives no weights."""

MAX_ECHO_DELAY = int(0.4 * SAMPLE_RATE)
"""Samples between the nominal time of the robot's loudspeaker and the arrival of its sound."""

ANALYSIS_WINDOW = np.sqrt(np.hanning(ECHO_WINDOW + 1)[:-1])


@on_one_thread
def cancel_echo(heard: Samples, played: npt.NDArray[np.float32]) -> Samples:
    """Remove the echo from recorded sound.

    Args:
        heard: the microphone's samples, 16 kHz.
        played: the loudspeaker's, ending at the same time and beginning earlier by the longest
            delay with which they may arrive.
    """
    start = len(played) - len(heard) - _find_delay(heard, played)
    source = _spectrum(played[start : start + len(heard)])
    sound = _spectrum(heard)
    moments = _delayed_copies(source)
    adjoint = moments.conj().transpose(0, 2, 1)
    power = adjoint @ moments
    mean = np.einsum("fkk->f", power).real / power.shape[1]
    ridge = RELATIVE_RIDGE * mean + 1e-9 * mean.max(initial=0) + 1e-12
    weights = np.linalg.solve(
        power + ridge[:, None, None] * np.eye(power.shape[1]), adjoint @ sound.T[:, :, None]
    )
    rest = sound - (moments @ weights)[:, :, 0].T
    samples = _samples(rest)[-len(heard) :]
    return np.clip(np.rint(samples), -32768, 32767).astype(np.int16)


def _find_delay(heard: Samples, played: npt.NDArray[np.float32]) -> int:
    """Return by how many samples `heard` comes after `played` (GCC-PHAT)."""
    size = len(heard) + len(played)
    cross = np.fft.rfft(heard, size) * np.fft.rfft(played, size).conj()
    likeness = np.fft.irfft(cross / np.maximum(np.abs(cross), 1e-9), size)
    longest = len(played) - len(
        heard
    )  # a shift of the whole `played`, which begins so much earlier
    shifts = np.arange(longest + 1)
    return int(shifts[np.argmax(likeness[shifts - longest])])


def _spectrum(samples: npt.NDArray[np.int16 | np.float32]) -> Spectrum:
    whole = np.pad(samples.astype(np.float64), (-len(samples) % ECHO_HOP, 0))  # the end counts
    frames = np.lib.stride_tricks.sliding_window_view(whole, ECHO_WINDOW)[::ECHO_HOP]
    return np.fft.rfft(frames * ANALYSIS_WINDOW, axis=1)


def _samples(spectrum: Spectrum) -> Floats:
    frames = np.fft.irfft(spectrum, axis=1) * ANALYSIS_WINDOW
    samples = np.zeros((len(frames) - 1) * ECHO_HOP + ECHO_WINDOW)
    for number, frame in enumerate(frames):
        samples[number * ECHO_HOP : number * ECHO_HOP + ECHO_WINDOW] += frame
    return samples * 2 * ECHO_HOP / ECHO_WINDOW


def _delayed_copies(source: Spectrum) -> Spectrum:
    """Return what was played around each frame, of shape (bands, frames, taps)."""
    frames, bands = source.shape
    moments = np.zeros((bands, frames, LEAD_TAPS + ROOM_TAPS), complex)
    for number, shift in enumerate(range(-LEAD_TAPS, ROOM_TAPS)):
        begin, end = max(0, shift), min(frames, frames + shift)
        moments[:, begin:end, number] = source[begin - shift : end - shift].T
    return moments
