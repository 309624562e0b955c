"""What a microphone hears of a reply by several loudspeakers, near and in rooms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import soxr

from voz.apps.evaluation.noise import room_response
from voz.audio import SAMPLE_RATE
from voz.audio.sound_files import read_samples
from voz.speech.synthesis import cached_speech

Floats = npt.NDArray[np.float64]

ROOM_NOISE = 8.0
"""Standard deviation of a quiet room, of 16 bits."""

SMALL_BAND = (300.0, 5500.0)
"""What a loudspeaker of some centimeters plays, Hz."""

SMALL_DRIVE, SMALL_SKEW = 2.0, 0.3
"""How far it is driven into its limits: of a loud vowel 4 % of the power is distortion."""

DRIFT = 1e-3
"""Difference of two cheap clocks, of the time; good ones have 1e-5 to 1e-4."""

HALL_FACTOR = 2
"""How many times longer a hall reverberates than a living room."""

BESIDE = 20.0
"""The direct sound over a room's echo where the microphone is beside the loudspeaker, dB."""


def linear(sound: Floats) -> Floats:
    """A perfect loudspeaker."""
    return sound


def a_little_distorted(sound: Floats) -> Floats:
    """Saturate as a loudspeaker that is turned up."""
    top = np.abs(sound).max() / 0.45
    return np.asarray(np.tanh(sound / top) * top)


def small(sound: Floats) -> Floats:
    """A small loudspeaker at its limits: few frequencies, and not the same up and down."""
    driven = SMALL_DRIVE * _band(sound) / np.abs(sound).max()
    return np.asarray(np.tanh(driven + SMALL_SKEW * driven**2))


def _band(sound: Floats) -> Floats:
    """Filter as a mechanical system of second order at both ends."""
    low, high = SMALL_BAND
    hertz = np.fft.rfftfreq(2 * len(sound), 1 / SAMPLE_RATE)
    below, above = hertz * 1j / low, hertz * 1j / high
    shape = below**2 / (1 + 1.2 * below + below**2) / (1 + 1.2 * above + above**2)
    heard: Floats = np.fft.irfft(np.fft.rfft(sound, 2 * len(sound)) * shape)[: len(sound)]
    return heard


@dataclass(frozen=True)
class EchoPath:
    """How a reply comes from the samples that are played to the microphone."""

    name: str  # for tables
    loudspeaker: Callable[[Floats], Floats]  # its distortion
    late: float = 0.06  # delay of the sound system, s
    drift: float = 0.0  # how much slower the loudspeaker's clock is, of the time
    beside: bool = False  # whether the microphone is beside the loudspeaker
    hall: bool = False  # whether the room is a hall
    spoken_before: bool = False  # whether the same reply was said just before

    def echo(self, played: Floats, power: float, rng: np.random.Generator) -> Floats:
        """What a microphone hears of samples of 16 kHz, as many, with so much power."""
        sound = self.loudspeaker(played)
        if self.drift:
            sound = soxr.resample(sound, SAMPLE_RATE, SAMPLE_RATE * (1 + self.drift), "VHQ")
        response = room_response(rng)
        if self.hall:
            length = HALL_FACTOR * len(response)
            echoes = rng.standard_normal(length) * 10 ** (-3 * np.arange(length) / length)
            response = np.concatenate([[1.0], echoes / np.sqrt(np.sum(echoes**2))])
        if self.beside:
            response[1:] *= 10 ** (-BESIDE / 20) / np.sqrt(np.sum(response[1:] ** 2))
        heard = np.convolve(sound, response)
        heard = np.concatenate([np.zeros(round(self.late * SAMPLE_RATE)), heard])[: len(played)]
        return np.asarray(heard * np.sqrt(power / loud_power(heard)))


PATHS = (
    EchoPath("perfect", linear),
    EchoPath("a little distorted", a_little_distorted),
    EchoPath("small, at its limits", small),
    EchoPath("small, 0.3 s late", small, late=0.3),
    EchoPath("small, a clock 0.1 % slow", small, drift=DRIFT),
    EchoPath("the same, it has spoken before", small, drift=DRIFT, spoken_before=True),
    EchoPath("small, beside the microphone", small, beside=True),
    EchoPath("small, in a hall", small, hall=True),
)


def loud_power(samples: Floats) -> float:
    """The mean power of all that is loud."""
    loud = samples[np.abs(samples) > 0.1 * np.abs(samples).max()]
    return float(np.mean(loud**2))


def speech(file: Path) -> Floats:
    """The samples of a recording."""
    return read_samples(file).astype(float)


@cache
def reply(text: str, voice: str) -> Floats:
    """The samples of a reply, without the silence around it."""
    samples = speech(cached_speech(text, voice))
    (sounds,) = np.nonzero(np.abs(samples) > 200)
    return samples[sounds[0] : sounds[-1]]


class Played:
    """A loudspeaker of the robot whose time is that of the samples."""

    def __init__(self, samples: Floats, end: float, text: str | None = None) -> None:
        self._samples = (samples / 32768).astype(np.float32)
        self._end = end
        self._text = text
        self.now = 0.0

    def busy_until(self) -> float:
        """The end of the reply."""
        return self._end

    def replies(self) -> str | None:
        """The words of the reply, if commands count that have none of them."""
        return self._text

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        """The samples before now."""
        at = round(self.now * SAMPLE_RATE)
        length = round(seconds * SAMPLE_RATE)
        padded = np.pad(self._samples, (length, max(0, at - len(self._samples))))
        return padded[at : at + length], self.now
