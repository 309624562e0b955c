"""Noise and rooms for clean recordings: the same seed gives the same samples.

rng = generator_for("commands/stop.flac")
heard = within(kitchen, reverberated(clean, room_response(rng)), 10, rng)
"""

from __future__ import annotations

import math
import zlib
from pathlib import Path

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError, ConfigError

Floats = npt.NDArray[np.float64]

NOISE_SEED = 1
"""The one seed of everything random here; another would only give another average."""

POWER_FRAME = SAMPLE_RATE // 50
"""Samples of 20 ms, in which speech is either there or not."""

ACTIVE_RANGE_DB = 30.0
"""Frames that are quieter than the loudest by more than this are pauses, dB."""

REVERBERATION_TIME = 0.4
"""Until the room is quieter by 60 dB, s: a furnished living room."""

DIRECT_TO_REVERBERANT = 3.0
"""How much stronger the direct path is than all echoes together, dB: about a metre away."""

NOISE_BEFORE, NOISE_AFTER = 5.0, 3.0
"""For how long noise goes on before and after what is said in it, s.

What is said has to be found in it, as in life: noise that begins and ends with a command gives it
away. Who follows the background knows it after 5 s; and what goes on for 3 s more is too long for
a command, so that none is heard only because the recording is over.
"""

NOISE_ENDINGS = (".wav", ".flac", ".ogg", ".mp3")
"""What is taken for noise in a folder; a file that is named may have any ending."""

LOWEST_RATIO, HIGHEST_RATIO = -20.0, 60.0
"""Below and above these signal-to-noise ratios there is nothing to measure, dB."""


def generator_for(file: str) -> np.random.Generator:
    """Make the randomness of one clip, so that it does not hang on which others there are."""
    return np.random.default_rng([NOISE_SEED, zlib.crc32(file.encode(errors="surrogateescape"))])


def speech_power(samples: Samples) -> float:
    """Measure speech without its pauses.

    Returns:
        The mean square of the active frames: those of 20 ms within 30 dB of the loudest; 0 for
        digital silence. What does not fill a frame at the end is left out.
    """
    whole = samples[: max(len(samples) // POWER_FRAME, 1) * POWER_FRAME].astype(np.float64)
    powers = (whole.reshape(-1, min(POWER_FRAME, len(whole))) ** 2).mean(axis=1)
    active = powers >= np.max(powers) * 10 ** (-ACTIVE_RANGE_DB / 10)
    return float(powers[active].mean())


def mix(speech: Samples, noise: Samples, ratio: float) -> Samples:
    """Mix noise into speech at a signal-to-noise ratio.

    The ratio is that of the power of the speech over its active frames (`speech_power`) to the
    power of the noise over its whole length.

    Args:
        speech: at least one sample.
        noise: of the same length, and not all 0.
        ratio: how much louder the speech is, dB.

    Returns:
        The sum; speech and noise are both turned down where they would overdrive 16 bits.
    """
    return _within_range(speech + _gain(speech, noise, ratio) * noise)


def embed_in_noise(
    noise: Samples, speech: Samples, ratio: float, rng: np.random.Generator
) -> Samples:
    """Let something be said in noise that goes on before and after it.

    Args:
        noise: not all 0. The ratio is that to its mean: where it comes and goes, as talk does,
            something may be said in a pause or against its loudest.
        speech: at least one sample.
        ratio: as for `mixed`, dB.
        rng: chooses the stretch of the noise.

    Returns:
        The sum, with `NOISE_BEFORE` and `NOISE_AFTER` around the speech.
    """
    around = (round(NOISE_BEFORE * SAMPLE_RATE), round(NOISE_AFTER * SAMPLE_RATE))
    padded = np.pad(speech, around)
    background = random_stretch(noise, len(padded), rng)
    return _within_range(padded + _gain(speech, noise, ratio) * background)


def random_stretch(noise: Samples, length: int, rng: np.random.Generator) -> Samples:
    """Cut a random stretch of so many samples out of noise, which is repeated if it is shorter."""
    repeated = np.tile(noise, math.ceil(length / len(noise)))
    start = rng.integers(len(repeated) - length + 1)
    return repeated[start : start + length]


def room_response(rng: np.random.Generator) -> Floats:
    """Make the impulse response of a room: the direct path and exponentially decaying noise.

    Returns:
        At 16 kHz: 1 for the direct path, then 0.4 s of echoes, which fall by 60 dB in that time.
    """
    length = int(REVERBERATION_TIME * SAMPLE_RATE)
    echoes = rng.standard_normal(length) * 10 ** (-3 * np.arange(length) / length)
    echoes *= math.sqrt(10 ** (-DIRECT_TO_REVERBERANT / 10) / np.sum(echoes**2))
    return np.concatenate(([1.0], echoes))


def reverberate(samples: Samples, response: Floats) -> Samples:
    """Play samples in a room.

    Args:
        samples: at least one.
        response: the room's impulse response at 16 kHz.

    Returns:
        The convolution, longer by the response; turned down if it would overdrive 16 bits.
    """
    length = len(samples) + len(response) - 1
    spectrum = np.fft.rfft(samples.astype(np.float64), length) * np.fft.rfft(response, length)
    return _within_range(np.fft.irfft(spectrum, length))


def noise_options(snr: str | None, path: Path | None) -> tuple[tuple[float, ...], list[Path]]:
    """Read what noise is asked for.

    Args:
        snr: signal-to-noise ratios in dB, with commas between them; None for no noise.
        path: a recording of noise, or a folder with recordings in it and below it.

    Returns:
        The ratios and the recordings; both empty for no noise.

    Raises:
        ConfigError: only one of them is given, or one cannot be used.
    """
    if snr is None and path is None:
        return (), []
    if snr is None or path is None:
        raise ConfigError("noise needs both, --snr for how loud and --noise for which; see --help")
    return parse_ratios(snr), noise_files(path)


def noise_files(path: Path) -> list[Path]:
    """Find the recordings of noise: the file itself, or all in a folder and those below it.

    Raises:
        ConfigError: there is none.
    """
    inside = sorted(path.rglob("*")) if path.is_dir() else []
    files = [path] if path.is_file() else [f for f in inside if f.suffix.lower() in NOISE_ENDINGS]
    if not files:
        raise ConfigError(f"{path}: holds no recording; name a recording of noise, or a folder")
    return files


def parse_ratios(text: str) -> tuple[float, ...]:
    """Read signal-to-noise ratios in dB as they are typed: `20,10,5`.

    Raises:
        ConfigError: it is no list of numbers, or one is out of all sense.
    """
    try:
        ratios = tuple(float(number) for number in text.split(","))
    except ValueError:
        ratios = (math.nan,)
    if not all(LOWEST_RATIO <= ratio <= HIGHEST_RATIO for ratio in ratios):
        raise ConfigError(
            f'--snr "{text}" is no list of ratios from {LOWEST_RATIO:g} to {HIGHEST_RATIO:g} dB; '
            "write for instance 20,10,5"
        )
    return ratios


def check_not_silent(noise: Samples, path: Path) -> None:
    """Raise AudioError if there is nothing in noise that could be turned up."""
    if not noise.any():
        raise AudioError(f"{path}: is silent, so it is no noise; use another recording")


def _gain(speech: Samples, noise: Samples, ratio: float) -> float:
    """What noise is multiplied by to be that much below speech, dB."""
    noise_power = float(np.mean(noise.astype(np.float64) ** 2))
    return math.sqrt(speech_power(speech) / noise_power / 10 ** (ratio / 10))


def _within_range(samples: Floats) -> Samples:
    loudest = float(np.abs(samples).max())
    return np.rint(samples * min(1.0, 32767 / max(loudest, 1.0))).astype(np.int16)
