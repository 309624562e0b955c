"""Noise and rooms for clean recordings: the same seed gives the same samples."""

from __future__ import annotations

import math
import zlib
from pathlib import Path

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import ConfigError

Floats = npt.NDArray[np.float64]

NOISE_SEED = 1
"""For everything random here."""

POWER_FRAME = SAMPLE_RATE // 50
"""Length of a frame of speech or pause, samples: 20 ms."""

ACTIVE_RANGE_DB = 30.0
"""Frames that are quieter than the loudest by more than this, dB, are pauses."""

REVERBERATION_TIME = 0.4
"""RT60 of a furnished living room, s."""

DIRECT_TO_REVERBERANT = 3.0
"""Power of the direct path to that of all echoes, dB: about a meter away."""

NOISE_BEFORE, NOISE_AFTER = 5.0, 3.0
"""Noise before and after speech, s.

5 s are enough to learn the background; 3 s more are too long for a command, so that none is heard
only because the recording ends.
"""

NOISE_ENDINGS = (".wav", ".flac", ".ogg", ".mp3")
"""Of files in a folder of noise; a file that is named may have any ending."""

LOWEST_RATIO, HIGHEST_RATIO = -20.0, 60.0
"""Signal-to-noise ratios that can be asked for, dB."""


def generator_for(file: str) -> np.random.Generator:
    """Make the random generator of one clip: the same whatever other clips there are."""
    return np.random.default_rng([NOISE_SEED, zlib.crc32(file.encode(errors="surrogateescape"))])


def speech_power(samples: Samples) -> float:
    """Return the mean square of speech without its pauses; 0 for digital silence.

    Counted are frames of 20 ms within 30 dB of the loudest; an incomplete last frame is not.
    """
    whole = samples[: max(len(samples) // POWER_FRAME, 1) * POWER_FRAME].astype(np.float64)
    powers = (whole.reshape(-1, min(POWER_FRAME, len(whole))) ** 2).mean(axis=1)
    active = powers >= np.max(powers) * 10 ** (-ACTIVE_RANGE_DB / 10)
    return float(powers[active].mean())


def mix(speech: Samples, noise: Samples, ratio: float) -> Samples:
    """Mix noise of the same length into speech at a signal-to-noise ratio, dB.

    The ratio is that of `speech_power` to the mean power of the noise. The sum is turned down where
    it would exceed 16 bits.
    """
    return _within_range(speech + _gain(speech, noise, ratio) * noise)


def embed_in_noise(
    noise: Samples, speech: Samples, ratio: float, rng: np.random.Generator
) -> Samples:
    """Mix speech into noise that goes on for `NOISE_BEFORE` and `NOISE_AFTER` around it.

    The stretch of the noise is random. The ratio, dB, is that to the mean power of all the noise:
    where that comes and goes, as talk does, the speech may be in a pause or in its loudest part.
    """
    around = (round(NOISE_BEFORE * SAMPLE_RATE), round(NOISE_AFTER * SAMPLE_RATE))
    padded = np.pad(speech, around)
    background = random_stretch(noise, len(padded), rng)
    return _within_range(padded + _gain(speech, noise, ratio) * background)


def random_stretch(noise: Samples, length: int, rng: np.random.Generator) -> Samples:
    """Cut a random stretch of so many samples out of noise, repeated if it is shorter."""
    repeated = np.tile(noise, math.ceil(length / len(noise)))
    start = rng.integers(len(repeated) - length + 1)
    return repeated[start : start + length]


def room_response(rng: np.random.Generator) -> Floats:
    """Make the impulse response of a room, at 16 kHz.

    That is 1 for the direct path, then 0.4 s of noise, which decays by 60 dB in that time.
    """
    length = int(REVERBERATION_TIME * SAMPLE_RATE)
    echoes = rng.standard_normal(length) * 10 ** (-3 * np.arange(length) / length)
    echoes *= math.sqrt(10 ** (-DIRECT_TO_REVERBERANT / 10) / np.sum(echoes**2))
    return np.concatenate(([1.0], echoes))


def reverberate(samples: Samples, response: Floats) -> Samples:
    """Convolve samples with an impulse response; turned down where it would exceed 16 bits."""
    length = len(samples) + len(response) - 1
    spectrum = np.fft.rfft(samples.astype(np.float64), length) * np.fft.rfft(response, length)
    return _within_range(np.fft.irfft(spectrum, length))


def noise_options(snr: str | None, path: Path | None) -> tuple[tuple[float, ...], list[Path]]:
    """Read `--snr`, ratios in dB, and `--noise`, a recording or a folder; None for no noise.

    Raises:
        ConfigError: only one of them is given, or one cannot be used.
    """
    if snr is None and path is None:
        return (), []
    if snr is None or path is None:
        raise ConfigError("--snr and --noise are needed together: how loud, and which noise")
    return parse_ratios(snr), noise_files(path)


def noise_files(path: Path) -> list[Path]:
    """Return the file itself, or all recordings below a folder; raises ConfigError without any."""
    inside = sorted(path.rglob("*")) if path.is_dir() else []
    files = [path] if path.is_file() else [f for f in inside if f.suffix.lower() in NOISE_ENDINGS]
    if not files:
        raise ConfigError(f"{path}: holds no recording; name a recording of noise, or a folder")
    return files


def parse_ratios(text: str) -> tuple[float, ...]:
    """Read signal-to-noise ratios in dB, as `20,10,5`; raises ConfigError for anything else."""
    try:
        ratios = tuple(float(number) for number in text.split(","))
    except ValueError:
        ratios = (math.nan,)
    if not all(LOWEST_RATIO <= ratio <= HIGHEST_RATIO for ratio in ratios):
        raise ConfigError(
            f'invalid --snr "{text}": ratios are from {LOWEST_RATIO:g} to {HIGHEST_RATIO:g} dB; '
            "write for instance 20,10,5"
        )
    return ratios


def _gain(speech: Samples, noise: Samples, ratio: float) -> float:
    """The factor that makes noise so much quieter than speech, dB."""
    noise_power = float(np.mean(noise.astype(np.float64) ** 2))
    return math.sqrt(speech_power(speech) / noise_power / 10 ** (ratio / 10))


def _within_range(samples: Floats) -> Samples:
    loudest = float(np.abs(samples).max())
    return np.rint(samples * min(1.0, 32767 / max(loudest, 1.0))).astype(np.int16)
