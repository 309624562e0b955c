"""Sounds that a robot's microphone hears beside speech, made from random numbers.

Each function takes a number of samples (16 kHz) and a generator of random numbers, and returns
float32 samples of no particular level.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import soxr
from numpy.random import Generator

from voz.audio import SAMPLE_RATE

Sound = npt.NDArray[np.float32]


def colored(length: int, rng: Generator) -> Sound:
    """Noise whose power falls with the frequency: fans, rain, wind, the sea."""
    return _shaped(length, rng, slope=rng.uniform(0, 2))


def wind(length: int, rng: Generator) -> Sound:
    """Low noise in gusts, as over an open microphone."""
    gusts = _slow(length, rng, rate=rng.uniform(0.5, 3))
    return (_shaped(length, rng, slope=2.5) * gusts**2).astype(np.float32)


def motors(length: int, rng: Generator) -> Sound:
    """Harmonics of a wandering speed on colored noise: a robot's drive, a vacuum cleaner."""
    speed = rng.uniform(40, 400) * (1 + 0.2 * (_slow(length, rng, rate=1.0) - 0.5))
    phase = 2 * np.pi * np.cumsum(speed) / SAMPLE_RATE
    sound = np.zeros(length)
    for harmonic in range(1, int(rng.integers(4, 20))):
        if harmonic * speed.max() < SAMPLE_RATE / 2:
            sound += rng.exponential() / harmonic * np.sin(harmonic * phase + rng.uniform(0, 6))
    sound /= sound.std() + 1e-9
    return (sound + rng.uniform(0.2, 2) * colored(length, rng)).astype(np.float32)


def clatter(length: int, rng: Generator) -> Sound:
    """Decaying bells, knocks and clicks: dishes, tools, footsteps, a keyboard."""
    sound = 0.02 * colored(length, rng)
    for _ in range(max(1, int(length / SAMPLE_RATE * rng.uniform(1, 8)))):
        start = int(rng.integers(length))
        time = np.arange(min(length - start, SAMPLE_RATE)) / SAMPLE_RATE
        decay = np.exp(-time / rng.uniform(0.003, 0.25))
        hit = rng.standard_normal(len(time)) * rng.uniform(0, 1)
        for _ in range(int(rng.integers(0, 6))):
            frequency = rng.uniform(150, 7000)
            hit += rng.uniform(0, 2) * np.sin(2 * np.pi * frequency * time + rng.uniform(0, 6))
        sound[start : start + len(time)] += (hit * decay * rng.exponential()).astype(np.float32)
    return sound


def music(length: int, rng: Generator) -> Sound:
    """Chords with overtones, a new one every half second or so, with a beat."""
    sound = np.zeros(length)
    start = 0
    while start < length:
        span = min(length - start, int(SAMPLE_RATE * rng.uniform(0.15, 1.0)))
        time = np.arange(span) / SAMPLE_RATE
        root = 55 * 2 ** (rng.integers(0, 36) / 12)
        chord = np.zeros(span)
        for interval in rng.choice([0, 3, 4, 7, 10, 12, 19], size=3):
            for overtone in range(1, 8):
                frequency = overtone * root * 2 ** (interval / 12)
                chord += np.sin(2 * np.pi * frequency * time) / overtone ** rng.uniform(0.7, 2)
        beat = rng.standard_normal(span) * np.exp(-time / 0.03) * rng.uniform(0, 3)
        sound[start : start + span] = (chord + beat) * np.exp(-time * rng.uniform(0, 4))
        start += span
    return sound.astype(np.float32)


MADE: dict[Callable[[int, Generator], Sound], float] = {
    colored: 0.10,
    wind: 0.03,
    motors: 0.12,
    clatter: 0.13,
    music: 0.07,
}
"""How often each is heard; the rest of the time it is people, or a recording."""


def _shaped(length: int, rng: Generator, slope: float) -> Sound:
    spectrum = np.fft.rfft(rng.standard_normal(length))
    frequency = np.maximum(np.fft.rfftfreq(length, 1 / SAMPLE_RATE), 30)
    sound = np.fft.irfft(spectrum * frequency ** (-slope / 2), length)
    return (sound / (sound.std() + 1e-9)).astype(np.float32)


def _slow(length: int, rng: Generator, rate: float) -> npt.NDArray[np.float64]:
    """A curve between 0 and 1 that takes a new direction `rate` times a second."""
    points = rng.uniform(0, 1, int(length / SAMPLE_RATE * rate) + 3)
    places = np.linspace(0, len(points) - 1, length)
    return np.interp(places, np.arange(len(points)), points)


def changed_speed(sound: Sound, factor: float) -> Sound:
    """Speech at another speed and pitch, as of a smaller or larger speaker."""
    return soxr.resample(sound, SAMPLE_RATE, SAMPLE_RATE / factor, quality="LQ")
