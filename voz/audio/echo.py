"""Echo cancellation: removes from the microphone's sound what the loudspeaker played.

In each frequency band the echo is a weighted sum of the last frames of what was played, and of its
square and cube, which a small loudspeaker adds; the weights are fitted by least squares to one
window (convolutive transfer function, Talmon, Cohen and Gannot 2009).
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples
from voz.process.one_thread import on_one_thread

Floats: TypeAlias = npt.NDArray[np.float64]
Spectrum: TypeAlias = npt.NDArray[np.complex64]

ECHO_WINDOW = 512
ECHO_HOP = 256

ECHO_EDGE = ECHO_WINDOW - ECHO_HOP
"""Samples at either end that are incomplete: some of their windows lie outside."""

ROOM_TAPS = 12
"""Frames of the past that the room reflects, 0.2 s."""

DISTORTION_TAPS = 4
"""The same of the distortion, 0.06 s: what comes later is too soft."""

LEAD_TAPS = 1
"""Frames by which the estimated delay may be too long."""

RELATIVE_RIDGE = 1e-3
"""Of the mean power, added to the diagonal so that silence gives no weights."""

MOST_RIDGE = 1e3
"""The same where nothing is known of the weights: they are 0."""

USUAL_POWERS = 10 ** (
    -6
    * (ECHO_HOP / SAMPLE_RATE / 0.5)
    * np.array([*[0] * LEAD_TAPS, *range(ROOM_TAPS), *2 * [*range(DISTORTION_TAPS)]])
) * np.repeat([1, 0.1], [LEAD_TAPS + ROOM_TAPS, 2 * DISTORTION_TAPS])
"""Of each weight, relative to the first: rooms lose 60 dB in half a second, distortion is less."""

MAX_ECHO_DELAY = int(0.4 * SAMPLE_RATE)
"""Samples between the nominal time of the robot's loudspeaker and the arrival of its sound."""

ANALYSIS_WINDOW = np.sqrt(np.hanning(ECHO_WINDOW + 1)[:-1])

DRIFT_BLOCK = 4000
"""Samples, 0.25 s, in which the delay hardly changes."""

DRIFTS = np.arange(-40, 41) * 31.25e-6
"""Differences of the clocks of loudspeaker and microphone that are tried; cheap ones have 1e-4."""

DRIFT_STEP = 4
"""Part of a sample to which delays are compared."""

MAX_DRIFT_LAG = 40
"""Samples by which the estimated delay may be wrong where the clocks differ."""

DRIFT_MEMORY = 0.95
"""Of what was known of the difference, kept for each window."""

SURE_OF_DRIFT = 1.1
"""How many times likelier a difference must be than none."""

MIN_DRIFT_POWER = 0.03
"""Of the loudest block; softer ones say nothing about the clocks."""


RESIDUE_BANDS = np.array([4, 8, 12, 16, 22, 28, 36, 46, 58, 74, 94, 118, 150, 190])
"""First frequencies of the bands in which the residue of an echo is compared, in lines."""

LOUD_ECHO = 0.05
"""Of the loudest echo in a band; in softer frames the residue is noise."""

USUAL_RESIDUE = 0.6
"""Quantile of the residue that counts as usual."""

ROOM_POWER = 8.0**2
"""Of a quiet room, in units of the 16 bits."""

MIN_FRAMES = 10
"""Least frames from which the usual residue can be taken."""

MIN_SOUNDING = 5
"""Least frames with playback from which it can be told that no echo of it is heard."""


class Cleaned(NamedTuple):
    """Sound without its echo, 16 kHz.

    Attributes:
        samples: what is left.
        played: what was played when it was heard, as many samples, -1 to 1.
        echo: what was removed, as many samples.
    """

    samples: Samples
    played: npt.NDArray[np.float32]
    echo: npt.NDArray[np.float32]

    def cut(self, part: slice) -> Cleaned:
        """Return a part of it."""
        return Cleaned(self.samples[part], self.played[part], self.echo[part])

    def followed_by(self, other: Cleaned, most: int) -> Cleaned:
        """Return the last samples, so many at most, of this and what follows."""
        return Cleaned(
            np.concatenate([self.samples, other.samples])[-most:],
            np.concatenate([self.played, other.played])[-most:],
            np.concatenate([self.echo, other.echo])[-most:],
        )

    def level_above_residue(self, begin: float, end: float) -> float:
        """Return how far a stretch, s, is above what is usually left of such an echo, dB.

        Minus infinity if too little stands around the stretch to know what is usual, infinity if
        no echo is heard there: then what was removed within the stretch is a part of the speech.
        """
        left, echo = _band_powers(self.samples), _band_powers(self.echo)
        frames = np.arange(len(left)) * ECHO_HOP / SAMPLE_RATE
        inside = (frames > begin - 2 * ECHO_HOP / SAMPLE_RATE) & (frames < end)
        if not inside.any() or np.sum(~inside) < MIN_FRAMES:
            return -np.inf
        sounding = _band_powers(self.played).sum(axis=1)
        beside = ~inside & (sounding >= LOUD_ECHO * sounding[inside].max())
        if np.sum(beside) >= MIN_SOUNDING and echo[beside].sum() < left[beside].sum():
            return np.inf
        loud = ~inside[:, np.newaxis] & (echo >= LOUD_ECHO * echo[~inside].max(axis=0))
        shares = np.where(loud, left / (echo + 1e-3), np.nan)
        usual = echo[inside] * np.minimum(1, np.nanquantile(shares, USUAL_RESIDUE, axis=0))
        noise = ROOM_POWER * np.sum(ANALYSIS_WINDOW**2) * np.diff(RESIDUE_BANDS, append=256)
        return float(10 * np.log10(max(1.0, left[inside].sum()) / (usual + noise).sum()))


NOTHING_CLEANED = Cleaned(np.zeros(0, np.int16), *np.zeros((2, 0), np.float32))


class EchoCanceller:
    """Removes the echo from windows of one microphone's sound, and learns how its clock drifts."""

    def __init__(self) -> None:
        self._drift_evidence = np.where(DRIFTS == 0, 0.3, 0.0)

    @on_one_thread
    def clean(self, heard: Samples, played: npt.NDArray[np.float32]) -> Cleaned:
        """Remove the echo from recorded sound.

        Args:
            heard: the microphone's samples, 16 kHz.
            played: the loudspeaker's, ending at the same time and beginning earlier by the longest
                delay with which they may arrive.
        """
        drift = self._drift
        if drift:
            played = _stretched(played, drift)
        end = len(played) - _find_delay(heard, played)
        self._learn_drift(heard, played[end - len(heard) : end], drift)
        played = played[end - len(heard) : end]
        rest = _rest(_spectrum(heard), _moments(played))
        left = np.clip(np.rint(_samples(rest)[-len(heard) :]), -32768, 32767).astype(np.int16)
        return Cleaned(left, played, heard.astype(np.float32) - left)

    @property
    def _drift(self) -> float:
        """By how much of the time the loudspeaker's clock is slow."""
        likeliest = int(np.argmax(self._drift_evidence))
        sure = self._drift_evidence[likeliest] > SURE_OF_DRIFT * self._drift_evidence[DRIFTS == 0]
        return float(DRIFTS[likeliest]) if sure else 0.0

    def _learn_drift(self, heard: Samples, played: npt.NDArray[np.float32], known: float) -> None:
        """Add up the likeness of blocks, each shifted as a drift would (GCC-PHAT)."""
        blocks = len(heard) // DRIFT_BLOCK
        size = -(-DRIFT_BLOCK // 512) * 512
        sounds, sources = (
            np.fft.rfft(samples[-blocks * DRIFT_BLOCK :].reshape(blocks, -1), size)
            for samples in (heard, played)
        )
        power = np.sum(np.abs(sources) ** 2, axis=1)
        cross = sounds * sources.conj()
        cross /= np.maximum(np.abs(cross), 1e-9)
        cross[power < MIN_DRIFT_POWER * power.max(initial=1e-9)] = 0
        alike = np.fft.irfft(cross, DRIFT_STEP * size)
        shifts = np.rint(
            (DRIFTS - known)[:, np.newaxis] * np.arange(blocks)[::-1] * -DRIFT_BLOCK * DRIFT_STEP
        ).astype(int)
        lags = np.arange(-MAX_DRIFT_LAG * DRIFT_STEP, MAX_DRIFT_LAG * DRIFT_STEP + 1)
        found = alike[np.arange(blocks)[:, np.newaxis], shifts[:, :, np.newaxis] + lags]
        self._drift_evidence *= DRIFT_MEMORY
        self._drift_evidence += found.sum(axis=1).max(axis=1)


def _stretched(played: npt.NDArray[np.float32], drift: float) -> npt.NDArray[np.float32]:
    """As it is heard from a loudspeaker whose clock is slow by a part of the time; same end."""
    import soxr

    longer: npt.NDArray[np.float32] = soxr.resample(played, 1.0, 1.0 + drift)
    return np.pad(longer, (max(0, len(played) - len(longer)), 0))[-len(played) :]


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


def _rest(sound: Spectrum, moments: Spectrum) -> Spectrum:
    """What of a sound, frames x bands, no sum of the moments explains.

    Solved twice: the more is left, as somebody speaks, the nearer to zero the weights are held, the
    more so those that are usually small (ridge regression with an empirical prior).
    """
    heard = sound.T[:, :, np.newaxis]
    adjoint = moments.conj().transpose(0, 2, 1)
    power, cross = adjoint @ moments, adjoint @ heard
    mean = np.einsum("fkk->f", power).real[:, np.newaxis] / power.shape[1]
    least = RELATIVE_RIDGE * mean + 1e-9 * mean.max(initial=0) + 1e-12
    echo = moments @ _solved(power, cross, least)
    left = np.mean(np.abs(heard - echo) ** 2, axis=1)
    gain = np.sum(np.abs(echo) ** 2, axis=1) / (least + power[:, LEAD_TAPS, LEAD_TAPS, None].real)
    usual = gain * USUAL_POWERS.astype(np.float32)
    ridge = least + np.minimum(left / (usual + 1e-12), MOST_RIDGE * (mean + 1))
    rest: Spectrum = sound - (moments @ _solved(power, cross, ridge))[:, :, 0].T
    return rest


def _solved(power: Spectrum, cross: Spectrum, ridge: npt.NDArray[np.float32]) -> Spectrum:
    diagonal = ridge[:, :, np.newaxis] * np.eye(power.shape[1], dtype=np.float32)
    found: Spectrum = np.linalg.solve(power + diagonal, cross)
    return found


def _moments(played: npt.NDArray[np.float32]) -> Spectrum:
    """What a loudspeaker makes of its samples, around each frame: bands x frames x taps."""
    top = np.abs(played).max(initial=1e-6)
    shape = played / top
    taps = (
        _delayed_copies(_spectrum(played), LEAD_TAPS, ROOM_TAPS),
        _delayed_copies(_spectrum(shape**2 * top), 0, DISTORTION_TAPS),
        _delayed_copies(_spectrum(shape**3 * top), 0, DISTORTION_TAPS),
    )
    return np.concatenate(taps, axis=2)


def _spectrum(samples: npt.NDArray[np.int16 | np.float32]) -> Spectrum:
    whole = np.pad(samples.astype(np.float32), (-len(samples) % ECHO_HOP, 0))  # the end counts
    frames = np.lib.stride_tricks.sliding_window_view(whole, ECHO_WINDOW)[::ECHO_HOP]
    return np.fft.rfft(frames * ANALYSIS_WINDOW, axis=1).astype(np.complex64)


def _band_powers(samples: npt.NDArray[np.int16 | np.float32]) -> npt.NDArray[np.float32]:
    powers = np.abs(_spectrum(samples)[:, :256]) ** 2
    return np.add.reduceat(powers, RESIDUE_BANDS, axis=1)


def _samples(spectrum: Spectrum) -> Floats:
    frames = np.fft.irfft(spectrum, axis=1) * ANALYSIS_WINDOW
    samples = np.zeros((len(frames) - 1) * ECHO_HOP + ECHO_WINDOW)
    for number, frame in enumerate(frames):
        samples[number * ECHO_HOP : number * ECHO_HOP + ECHO_WINDOW] += frame
    return samples * 2 * ECHO_HOP / ECHO_WINDOW


def _delayed_copies(source: Spectrum, lead: int, taps: int) -> Spectrum:
    """Return what was played around each frame, of shape (bands, frames, taps)."""
    frames, bands = source.shape
    moments = np.zeros((bands, frames, lead + taps), np.complex64)
    for number, shift in enumerate(range(-lead, taps)):
        begin, end = max(0, shift), min(frames, frames + shift)
        moments[:, begin:end, number] = source[begin - shift : end - shift].T
    return moments
