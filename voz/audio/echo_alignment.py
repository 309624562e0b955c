"""Finds where in what the loudspeaker played the microphone's sound is, and whether it is there."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples

MAX_ECHO_DELAY = int(0.4 * SAMPLE_RATE)
"""Samples between the nominal time of the robot's loudspeaker and the arrival of its sound."""

DELAY_TAPER = SAMPLE_RATE // 10
"""Samples at both ends that are faded before the delay is sought: edges look alike."""

MIN_LIKENESS = 25.0
"""Of an echo, in standard deviations of the cross-correlation.

Of 84 replies in headphones, one reached 23; of 672 by loudspeakers, 10 dB softer than the speaker
to 10 dB louder, none stayed below 45 for its whole length.
"""

LIKENESS_MEMORY = 0.98
"""Of the greatest likeness, kept for each window."""

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

NO_DRIFT_EVIDENCE = 1e-4
"""Of no difference, before anything is heard; a window with an echo adds 1e-3 to 10."""

WHITENING = 0.7
"""Power of the magnitude by which blocks are divided; with 1, bands without sound count as well."""

MIN_DRIFT_POWER = 0.03
"""Of the loudest block; softer ones say nothing about the clocks."""


class EchoAligner:
    """Aligns what was played with windows of one microphone's sound; learns how its clock drifts.

    By generalized cross-correlation with phase transform (GCC-PHAT, Knapp and Carter 1976).
    """

    def __init__(self) -> None:
        self._likeness = 0.0  # greatest of late
        self._drift_evidence = np.where(DRIFTS == 0, NO_DRIFT_EVIDENCE, 0.0)

    @property
    def is_heard(self) -> bool:
        """Whether an echo was found of late."""
        return self._likeness >= MIN_LIKENESS

    def align(self, heard: Samples, played: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return the part of `played` of which the echo is in `heard`, as by the same clock.

        They are as for `EchoCanceller.clean`.
        """
        drift = self._drift
        aligned, likeness = _aligned(heard, played, drift)
        self._likeness = max(likeness, LIKENESS_MEMORY * self._likeness)
        if self.is_heard:
            self._learn_drift(heard, aligned, drift)
        if self._drift != drift:
            aligned, _ = _aligned(heard, played, self._drift)
        return aligned

    @property
    def _drift(self) -> float:
        """By how much of the time the loudspeaker's clock is slow."""
        likeliest = int(np.argmax(self._drift_evidence))
        sure = self._drift_evidence[likeliest] > SURE_OF_DRIFT * self._drift_evidence[DRIFTS == 0]
        return float(DRIFTS[likeliest]) if sure else 0.0

    def _learn_drift(self, heard: Samples, played: npt.NDArray[np.float32], known: float) -> None:
        """Add up the likeness of blocks, each shifted as a drift would.

        All delays count, as a room has many.
        """
        blocks = len(heard) // DRIFT_BLOCK
        size = -(-DRIFT_BLOCK // 512) * 512
        sounds, sources = (
            np.fft.rfft(samples[-blocks * DRIFT_BLOCK :].reshape(blocks, -1), size)
            for samples in (heard, played)
        )
        power = np.sum(np.abs(sources) ** 2, axis=1)
        cross = sounds * sources.conj()
        cross /= np.maximum(np.abs(cross), 1e-9) ** WHITENING
        cross /= np.sqrt(np.mean(np.abs(cross) ** 2, axis=1, keepdims=True)) + 1e-9
        cross[power < MIN_DRIFT_POWER * power.max(initial=1e-9)] = 0
        alike = np.fft.irfft(cross, DRIFT_STEP * size)
        shifts = np.rint(
            (DRIFTS - known)[:, np.newaxis] * np.arange(blocks)[::-1] * -DRIFT_BLOCK * DRIFT_STEP
        ).astype(int)
        lags = np.arange(-MAX_DRIFT_LAG * DRIFT_STEP, MAX_DRIFT_LAG * DRIFT_STEP + 1)
        found = alike[np.arange(blocks)[:, np.newaxis], shifts[:, :, np.newaxis] + lags]
        self._drift_evidence *= DRIFT_MEMORY
        self._drift_evidence += np.sum(np.maximum(found.sum(axis=1), 0) ** 2, axis=1) ** 2


def _stretched(played: npt.NDArray[np.float32], drift: float) -> npt.NDArray[np.float32]:
    """As it is heard from a loudspeaker whose clock is slow by a part of the time; same end."""
    import soxr

    longer: npt.NDArray[np.float32] = soxr.resample(played, 1.0, 1.0 + drift)
    return np.pad(longer, (max(0, len(played) - len(longer)), 0))[-len(played) :]


def _aligned(
    heard: Samples, played: npt.NDArray[np.float32], drift: float
) -> tuple[npt.NDArray[np.float32], float]:
    """Return the part of `played` that is heard, by a drifting clock, and how sure that is."""
    if drift:
        played = _stretched(played, drift)
    delay, likeness = _find_delay(heard, played)
    return played[len(played) - delay - len(heard) : len(played) - delay], likeness


def _find_delay(heard: Samples, played: npt.NDArray[np.float32]) -> tuple[int, float]:
    """Return by how many samples `heard` comes after `played`, and how sure that is."""
    size = len(heard) + len(played)
    cross = np.fft.rfft(_faded(heard), size) * np.fft.rfft(_faded(played), size).conj()
    likeness = np.fft.irfft(cross / np.maximum(np.abs(cross), 1e-9), size)
    longest = len(played) - len(heard)
    possible = likeness[np.arange(longest + 1) - longest]
    delay = int(np.argmax(possible))
    return delay, float(possible[delay] / (np.std(likeness) + 1e-9))


def _faded(samples: npt.NDArray[np.int16 | np.float32]) -> npt.NDArray[np.float64]:
    ramp = np.hanning(2 * DELAY_TAPER)
    faded = samples.astype(np.float64)
    faded[:DELAY_TAPER] *= ramp[:DELAY_TAPER]
    faded[-DELAY_TAPER:] *= ramp[DELAY_TAPER:]
    return faded
