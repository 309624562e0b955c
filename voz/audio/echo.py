"""Echo cancellation: removes from the microphone's sound what the loudspeaker played.

In each frequency band the echo is a weighted sum of the last frames of what was played, and of its
square and cube, which a small loudspeaker adds, with and without the frequencies that it is too
small to play; the weights are fitted by least squares to one window (convolutive transfer function,
Talmon, Cohen and Gannot 2009).
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.echo_alignment import EchoAligner
from voz.process.one_thread import on_one_thread

Floats: TypeAlias = npt.NDArray[np.float64]
Spectrum: TypeAlias = npt.NDArray[np.complex64]
Powers: TypeAlias = npt.NDArray[np.float32]

ECHO_WINDOW = 512
ECHO_HOP = 256

ECHO_EDGE = ECHO_WINDOW - ECHO_HOP
"""Samples at either end that are incomplete: some of their windows lie outside."""

ROOM_TAPS = 20
"""Frames of the past that the room reflects, 0.32 s."""

LOWEST_PLAYED = 250.0
"""What is lower hardly moves the cone of a small loudspeaker, Hz: it distorts the rest alone."""

DISTORTION_POWERS = (2, 3)
"""Of its samples, which a loudspeaker adds."""

DISTORTIONS = 2 * len(DISTORTION_POWERS)
"""Those of what was played, and of the same without what is lower than `LOWEST_PLAYED`."""

DISTORTION_TAPS = 4
"""Frames of the past of each distortion, 0.06 s: what comes later is too soft."""

LEAD_TAPS = 1
"""Frames by which the estimated delay may be too long."""

RELATIVE_RIDGE = 1e-3
"""Of the mean power, added to the diagonal so that silence gives no weights."""

MOST_RIDGE = 1e3
"""The same where nothing is known of the weights: they are 0."""

USUAL_POWERS = 10 ** (
    -6
    * (ECHO_HOP / SAMPLE_RATE / 0.5)
    * np.array([*[0] * LEAD_TAPS, *range(ROOM_TAPS), *DISTORTIONS * [*range(DISTORTION_TAPS)]])
) * np.repeat([1, 0.1], [LEAD_TAPS + ROOM_TAPS, DISTORTIONS * DISTORTION_TAPS])
"""Of each weight, relative to the first: rooms lose 60 dB in half a second, distortion is less."""

ANALYSIS_WINDOW = np.sqrt(np.hanning(ECHO_WINDOW + 1)[:-1])


RESIDUE_BANDS = np.array([4, 8, 12, 16, 22, 28, 36, 46, 58, 74, 94, 118, 150, 190])
"""First frequencies of the bands in which the residue of an echo is compared, in lines."""

LOUD_ECHO = 0.05
"""Of the loudest echo in a band; in softer frames the residue is noise."""

USUAL_RESIDUE = 0.5
"""Quantile of the residue that counts as usual."""

LEAST_RESIDUE = 0.01
"""Of the echo's power, that counts as usually left: nobody is heard who is softer."""

LEAST_OVER_RESIDUE = 2.0
"""Where somebody is heard, so many times the power is left that usually is."""

RESIDUE_FRAMES = 7
"""Frames over which that is compared, 0.11 s."""

ROOM_POWER = 8.0**2
"""Of a quiet room, in units of the 16 bits."""

MIN_FRAMES = 10
"""Least frames from which the usual residue can be taken."""

MIN_SOUNDING = 5
"""Least frames with playback from which it can be told that no echo of it is heard."""


class Cleaned(NamedTuple):
    """Sound without its echo, 16 kHz."""

    samples: Samples  # what is left
    played: npt.NDArray[np.float32]  # what was played when it was heard, as many samples, -1 to 1
    echo: npt.NDArray[np.float32]  # what was removed, as many samples

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
        usual = _usual_residue(left, echo, ~inside)[inside]
        noise = ROOM_POWER * np.sum(ANALYSIS_WINDOW**2) * np.diff(RESIDUE_BANDS, append=256)
        return float(10 * np.log10(max(1.0, left[inside].sum()) / (usual + noise).sum()))

    def may_be_played(self) -> npt.NDArray[np.bool_]:
        """Return for each sample whether it may be what was played, and nobody is heard over it.

        That is where little more is left than usually of the echo, and where none was removed.
        """
        left, echo = _band_powers(self.samples), _band_powers(self.echo)
        usual = _usual_residue(left, echo, np.ones(len(echo), np.bool_))
        around = np.ones(RESIDUE_FRAMES)
        heard, least = (np.convolve(p.sum(axis=1), around, "same") for p in (left, usual))
        frames = np.repeat((heard < LEAST_OVER_RESIDUE * least) | (least == 0), ECHO_HOP)
        return np.pad(frames, (ECHO_HOP // 2, ECHO_HOP), "edge")[: len(self.samples)]


NOTHING_CLEANED = Cleaned(np.zeros(0, np.int16), *np.zeros((2, 0), np.float32))


class EchoCanceller:
    """Removes the echo from windows of one microphone's sound.

    Where no echo is heard, as in headphones, nothing is removed: it could only be speech.
    """

    def __init__(self) -> None:
        self._aligner = EchoAligner()

    @on_one_thread
    def clean(self, heard: Samples, played: npt.NDArray[np.float32]) -> Cleaned:
        """Remove the echo from recorded sound, 16 kHz.

        What was played ends at the same time, and begins earlier by the longest delay with which it
        may arrive.
        """
        aligned = self._aligner.align(heard, played)
        if not self._aligner.is_heard:
            return Cleaned(heard, aligned, np.zeros(len(heard), np.float32))
        rest = _rest(_spectrum(heard), _moments(aligned))
        left = np.clip(np.rint(_samples(rest)[-len(heard) :]), -32768, 32767).astype(np.int16)
        return Cleaned(left, aligned, heard.astype(np.float32) - left)


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
    distorted = [*_powers(played), *_powers(_without_lowest(played))]
    taps = [_delayed_copies(_spectrum(sound), 0, DISTORTION_TAPS) for sound in distorted]
    return np.concatenate([_delayed_copies(_spectrum(played), LEAD_TAPS, ROOM_TAPS), *taps], axis=2)


def _powers(samples: npt.NDArray[np.float32]) -> list[npt.NDArray[np.float32]]:
    """Return the powers of samples that distortion adds, each as loud as the samples at most."""
    top = np.abs(samples).max(initial=1e-6)
    return [(samples / top) ** power * top for power in DISTORTION_POWERS]


def _without_lowest(samples: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Filter by a Butterworth high-pass of second order."""
    length = 2 * len(samples)  # what rings beyond the end must not come back at the beginning
    hertz = 1j * np.fft.rfftfreq(length, 1 / SAMPLE_RATE) / LOWEST_PLAYED
    gain = hertz**2 / (1 + np.sqrt(2) * hertz + hertz**2)
    filtered = np.fft.irfft(np.fft.rfft(samples, length) * gain, length)
    return filtered[: len(samples)].astype(np.float32)


def _spectrum(samples: npt.NDArray[np.int16 | np.float32]) -> Spectrum:
    whole = np.pad(samples.astype(np.float32), (-len(samples) % ECHO_HOP, 0))  # the end counts
    frames = np.lib.stride_tricks.sliding_window_view(whole, ECHO_WINDOW)[::ECHO_HOP]
    return np.fft.rfft(frames * ANALYSIS_WINDOW, axis=1).astype(np.complex64)


def _band_powers(samples: npt.NDArray[np.int16 | np.float32]) -> Powers:
    powers = np.abs(_spectrum(samples)[:, :256]) ** 2
    return np.add.reduceat(powers, RESIDUE_BANDS, axis=1)


def _usual_residue(left: Powers, echo: Powers, among: npt.NDArray[np.bool_]) -> Powers:
    """What is usually left of such an echo, frames x bands, by what is left in some frames."""
    loud = among[:, np.newaxis] & (echo >= LOUD_ECHO * echo[among].max(axis=0))
    shares = np.where(loud, left / (echo + 1e-3), np.nan)
    usual = np.nanquantile(shares, USUAL_RESIDUE, axis=0)
    return np.asarray(echo * np.clip(usual, LEAST_RESIDUE, 1), np.float32)


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
