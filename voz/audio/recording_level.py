"""The level of a recording, and what is wrong with it for speech recognition.

The limits are where commands begin to be lost, as `benchmarks/microphone.py` measures.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

import numpy as np

from voz.audio import Samples
from voz.audio.denoise import ENERGY_FRAME, Floats, frame_energies
from voz.audio.voice_detector import SILERO_BLOCK, Silero

FULL_SCALE_DB = 20 * math.log10(32768)
"""The highest level of 16 bits, dB relative to one unit."""

MIN_DBFS = -FULL_SCALE_DB
"""One unit of the 16 bits, dBFS; digital silence has this level, too."""

MAX_SILENT_RANGE = 2
"""Units between the lowest and the highest sample of a microphone that is off."""

TOO_QUIET = -40.0
"""Speech below this is too quiet, dBFS: 91 of 100 commands are obeyed between -50 and -45."""

MIN_SNR = 18.0
"""Speech closer to the background is noisy, dB: 74 of 100 are obeyed between 14 and 18."""

OBEYED_BY_SNR = ((25.0, 97), (18.0, 92), (13.0, 85), (8.0, 79))
"""Speech above background, dB, and how many of 100 commands are obeyed (`benchmarks/rooms.py`)."""

TOP_SHARE = 0.95
"""Samples above this share of the highest one count as clipped."""

MAX_CLIPPED_SHARE = 0.01
"""Of the speech; a clean voice has 0.001. Of 100 commands 82 are obeyed just above it."""

SPEECH_PROBABILITY, NO_SPEECH_PROBABILITY = 0.5, 0.2
"""A block above the first is speech, below the second background."""

SYLLABLE_BLOCKS = 6
"""Blocks, 0.2 s, over which the mean probability of speech is taken."""

MIN_BACKGROUND_FRAMES = 20
"""Frames of 10 ms; with fewer there is no pause to measure the background in."""


class Fault(enum.Enum):
    """A fault of a recording, and what to do."""

    SILENT = (
        "silent: the microphone gives nothing but zeros",
        "unmute it, by its switch or in the sound settings, or choose another with --device",
    )
    NO_SPEECH = (
        "no speech was heard",
        "say something while it records; if you did, speak closer to the microphone, turn its "
        "level up in the sound settings, or choose another with --device",
    )
    CLIPPED = (
        "clipped: the speech is louder than the microphone can take",
        "turn its level down in the sound settings, or speak from further away",
    )
    TOO_QUIET = (
        "too quiet: the speech is hardly louder than nothing",
        "speak closer to the microphone, or turn its level up in the sound settings",
    )
    NOISY = (
        "noisy: the background is too loud beside the speech",
        "speak closer to the microphone, take it away from what is loud, or use a headset",
    )

    def __init__(self, words: str, advice: str) -> None:
        self.words = words
        self.advice = advice


@dataclass(frozen=True)
class RecordingLevel:
    """The level of a recording."""

    still: bool  # whether all samples are the same, but for noise of a converter
    peak: float  # the highest sample, dBFS
    speech: float | None  # mean power of the speech, dBFS; None without speech
    background: float  # power of the rest, dBFS
    at_top: float  # share of clipped samples in the speech, 0 to 1

    @property
    def above_background(self) -> float | None:
        """Speech above background, dB."""
        return None if self.speech is None else self.speech - self.background


def obeyed_of_100(above: float) -> int | None:
    """Return how many of 100 commands are obeyed at this level above the background, dB."""
    return next((share for least, share in OBEYED_BY_SNR if above >= least), None)


def dbfs(samples: Samples | Floats) -> float:
    """Mean power of samples, dBFS; at least that of one unit."""
    return 10 * math.log10(float(np.mean(samples.astype(np.float64) ** 2)) + 1) - FULL_SCALE_DB


def measure_level(samples: Samples) -> RecordingLevel:
    """Measure a recording, 16 kHz, in which somebody should speak; best 3 s with a pause."""
    highest = float(np.abs(samples.astype(np.float64)).max())
    peak = 20 * math.log10(max(highest, 1.0)) - FULL_SCALE_DB
    if np.ptp(samples.astype(np.int32)) <= MAX_SILENT_RANGE:
        return RecordingLevel(True, peak, None, MIN_DBFS, 0.0)
    sound = samples - samples.mean()  # some converters are off zero
    voice = _speech_probabilities(sound)
    frames = frame_energies(sound) - FULL_SCALE_DB
    background = _background(frames, voice)
    spoken = sound[: len(voice) * SILERO_BLOCK].reshape(-1, SILERO_BLOCK)[
        voice >= SPEECH_PROBABILITY
    ]
    if not _has_speech(voice):
        return RecordingLevel(False, peak, None, background, 0.0)
    loudness = np.abs(spoken)
    at_top = float(np.mean(loudness >= TOP_SHARE * loudness.max()))
    return RecordingLevel(False, peak, dbfs(spoken), background, at_top)


def find_faults(level: RecordingLevel) -> list[Fault]:
    """List the faults of a recording, the worst first."""
    if level.still:
        return [Fault.SILENT]
    if level.speech is None:
        return [Fault.NO_SPEECH]
    found = {
        Fault.CLIPPED: level.at_top > MAX_CLIPPED_SHARE,
        Fault.TOO_QUIET: level.speech < TOO_QUIET,
        Fault.NOISY: level.speech - level.background < MIN_SNR,
    }
    return [fault for fault, there in found.items() if there]


def _speech_probabilities(sound: Floats) -> Floats:
    """Rate each block, after amplification: the network depends on the level."""
    louder = sound * (0.5 * 32767 / np.abs(sound).max())
    return Silero().probabilities(louder.astype(np.int16)).astype(np.float64)


def _has_speech(voice: Floats) -> bool:
    if len(voice) < SYLLABLE_BLOCKS:
        return False
    means = np.convolve(voice, np.full(SYLLABLE_BLOCKS, 1 / SYLLABLE_BLOCKS), "valid")
    return bool(means.max() >= SPEECH_PROBABILITY)


def _background(frames: Floats, voice: Floats) -> float:
    """Return the median level of frames without speech, dBFS; else of the quietest tenth."""
    if not len(frames):
        return MIN_DBFS
    blocks = (np.arange(len(frames)) * ENERGY_FRAME + ENERGY_FRAME // 2) // SILERO_BLOCK
    inside = blocks < len(voice)
    quiet = frames[inside][voice[blocks[inside]] < NO_SPEECH_PROBABILITY]
    if len(quiet) < MIN_BACKGROUND_FRAMES:
        quiet = np.sort(frames)[: max(1, len(frames) // 10)]
    return float(np.median(quiet))
