"""What the student hears in place of a clean clip: a room, a device, noise, a level."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from noises import MADE, Sound
from numpy.random import Generator

from voz.audio import SAMPLE_RATE

CLEAN, NOTHING = 0.25, 0.03
"""How often the student hears no noise, and how often nothing but noise."""

ROOM, DEVICE = 0.35, 0.40
"""How often there is an echo, and how often a device that colors the sound."""

PEOPLE, ONE_TALKER, RECORDED = 0.22, 0.16, 0.17
"""How often the noise is several people, one person, or a recording; `MADE` has the rest."""

LEVEL = 0.05
"""Mean square root of speech where people speak, full scale is 1."""

RATIOS = ((0.50, 5, 15), (0.25, -3, 8), (0.25, 12, 28))
"""How often the speech is louder than the noise by how much, dB."""


FAST_STEP = 1024


class Pool(Protocol):
    """Where clips come from at random."""

    def speech(self, rng: Generator) -> Sound:
        """A clip of a person."""

    def noise(self, length: int, rng: Generator) -> Sound | None:
        """A stretch of a recorded noise; None if there is none."""


def at_level(sound: Sound, level: float = LEVEL) -> Sound:
    """Bring the loud parts of a clip to a level; silence stays silence."""
    return (sound * (level / (np.sqrt(active_power(sound)) + 1e-6))).astype(np.float32)


def active_power(sound: Sound) -> float:
    """Mean power of the 20 ms that are within 30 dB of the loudest."""
    frame = SAMPLE_RATE // 50
    whole = sound[: len(sound) // frame * frame].reshape(-1, frame).astype(np.float64)
    power = (whole**2).mean(axis=1) if len(whole) else np.zeros(1)
    return float(power[power >= power.max() * 1e-3].mean())


def augment(clean: Sound, pool: Pool, rng: Generator) -> Sound:
    """Mix what the student hears.

    Args:
        clean: a clip at `LEVEL`, with silence around it.
        pool: the other people and the recorded noises.
        rng: every chance of it.

    Returns:
        As many samples, in which the speech stands at the same place.
    """
    sound = _in_room(clean, rng) if rng.random() < ROOM else clean
    if rng.random() >= CLEAN:
        noise = _noise(len(sound), pool, rng)
        shares = [share for share, _, _ in RATIOS]
        _, low, high = RATIOS[rng.choice(len(RATIOS), p=shares)]
        power = np.mean(noise.astype(np.float64) ** 2) + 1e-12
        sound = sound + noise * (LEVEL / np.sqrt(power) / 10 ** (rng.uniform(low, high) / 20))
    if rng.random() < DEVICE:
        sound = _through_device(sound, rng)
    sound = sound + rng.standard_normal(len(sound)) * 10 ** rng.uniform(-5, -3)
    sound = sound * 10 ** rng.uniform(-1.2, 0.9)
    return np.clip(sound, -1, 1).astype(np.float32)


def _noise(length: int, pool: Pool, rng: Generator) -> Sound:
    chance = rng.random()
    if chance < PEOPLE:
        return _people(length, pool, rng, int(rng.integers(3, 9)))
    if chance < PEOPLE + ONE_TALKER:
        return _people(length, pool, rng, 1)
    if chance < PEOPLE + ONE_TALKER + RECORDED:
        recorded = pool.noise(length, rng)
        if recorded is not None:
            return recorded
    kinds, weights = list(MADE), np.array([*MADE.values()])
    return kinds[rng.choice(len(kinds), p=weights / weights.sum())](length, rng)


def _people(length: int, pool: Pool, rng: Generator, count: int) -> Sound:
    """People who talk all the time."""
    sound = np.zeros(length, np.float32)
    for _ in range(count):
        place = -int(rng.integers(SAMPLE_RATE))
        loudness = 10 ** rng.uniform(-0.3, 0.3)
        while place < length:
            clip = at_level(pool.speech(rng)) * loudness
            begin, end = max(0, place), min(length, place + len(clip))
            if end > begin:
                sound[begin:end] += clip[begin - place : end - place]
            place += len(clip) + int(rng.integers(SAMPLE_RATE // 4))
    return _in_room(sound, rng) if rng.random() < 0.5 else sound


def _in_room(sound: Sound, rng: Generator) -> Sound:
    """An echo of decaying noise behind the direct sound, which keeps its place."""
    decay = rng.uniform(0.08, 0.6)  # to -60 dB, s
    time = np.arange(int(decay * SAMPLE_RATE)) / SAMPLE_RATE
    echo = rng.standard_normal(len(time)) * 10 ** (-3 * time / decay)
    echo[: int(rng.uniform(0.001, 0.01) * SAMPLE_RATE)] = 0
    echo *= 10 ** (rng.uniform(-12, 3) / 20) / (np.sqrt((echo**2).sum()) + 1e-9)
    echo[0] = 1
    size = fast_size(len(sound) + len(echo))
    both = np.fft.rfft(sound, size) * np.fft.rfft(echo, size)
    return np.fft.irfft(both, size)[: len(sound)].astype(np.float32)


def _through_device(sound: Sound, rng: Generator) -> Sound:
    """An uneven response of up to 12 dB, sometimes the band of a telephone, sometimes clipped."""
    size = fast_size(len(sound))
    spectrum = np.fft.rfft(sound, size)
    frequency = np.fft.rfftfreq(size, 1 / SAMPLE_RATE)
    corners = np.array([0, 100, 250, 500, 1000, 2000, 4000, 8000])
    gain = np.interp(np.log1p(frequency), np.log1p(corners), rng.uniform(-6, 6, len(corners)))
    if rng.random() < 0.25:
        low, high = rng.uniform(100, 350), rng.uniform(3000, 4500)
        gain -= 40 * ((frequency < low) | (frequency > high))
    filtered = np.fft.irfft(spectrum * 10 ** (gain / 20), size)
    sound = filtered[: len(sound)].astype(np.float32)
    if rng.random() < 0.1:
        limit = rng.uniform(0.3, 1) * np.abs(sound).max()
        sound = np.clip(sound, -limit, limit)
    return sound


def fast_size(size: int) -> int:
    """The next size without large prime factors: these make a Fourier transform slow."""
    return -(-size // FAST_STEP) * FAST_STEP
