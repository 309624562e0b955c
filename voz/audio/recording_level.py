"""How loud a recording is, and what is wrong with it for whoever wants it understood: pure.

The limits are where commands begin to be lost: `benchmarks/microphone.py` takes such as are obeyed,
by synthetic voices and by people, and makes them quieter, cuts them off and puts noise behind them.
"""

from __future__ import annotations

import enum
import math
from typing import NamedTuple

import numpy as np

from voz.audio import Samples
from voz.audio.denoise import ENERGY_FRAME, Floats, frame_energies
from voz.audio.endpointing.silero import SILERO_BLOCK, Silero

FULL_SCALE_DB = 20 * math.log10(32768)
"""The loudest that 16 bits hold, dB over one unit."""

MIN_DBFS = -FULL_SCALE_DB
"""One unit of the 16 bits, dBFS: digital silence is not told from it."""

MAX_SILENT_RANGE = 2
"""Units between the lowest and the highest sample of what may be a converter that hears nothing."""

TOO_QUIET = -40.0
"""Speech below it is too quiet, dBFS: of 100, 91 are obeyed between -50 and -45, and 41 between -60
and -50. Nobody speaks equally loudly all the time, hence 5 dB more."""

MIN_SNR = 18.0
"""Speech by less above the background is noisy, dB: of 100, 90 are obeyed between 18 and 22, 74
between 14 and 18, 49 between 5 and 10."""

OBEYED_BY_SNR = ((25.0, 97), (18.0, 92), (13.0, 85), (8.0, 79))
"""Above a sound that goes on by so much, dB, so many of 100 commands are obeyed: the means that
`benchmarks/rooms.py` prints in quiet, and at 20, 15 and 10 dB."""

TOP_SHARE = 0.95
"""Of the highest sample: what is above it is at the top."""

MAX_CLIPPED_SHARE = 0.01
"""Of the samples of speech; a clean voice has 0.001. Of 100, 98 are obeyed below it, 82 just above,
and 53 where a fifth is at the top."""

SPEECH_PROBABILITY, NO_SPEECH_PROBABILITY = 0.5, 0.2
"""Probabilities above and below which 32 ms are speech or background; between, neither."""

SYLLABLE_BLOCKS = 6
"""Blocks, a fifth of a second: only what is speech for so long, on average, is speech."""

MIN_BACKGROUND_FRAMES = 20
"""Frames of 10 ms that tell the background; with fewer, somebody speaks all the time."""


class Fault(enum.Enum):
    """What can be wrong with a recording: in words, and what to do."""

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


class RecordingLevel(NamedTuple):
    """How loud a recording is; dBFS are dB under the loudest that 16 bits hold.

    Attributes:
        still: whether nothing moves in it.
        peak: the highest sample, dBFS.
        speech: the mean power where somebody speaks, dBFS; None if nobody does.
        background: the power of most that is no speech, dBFS.
        at_top: how much of the speech is as loud as its loudest, 0 to 1; 0 without speech.
    """

    still: bool
    peak: float
    speech: float | None
    background: float
    at_top: float

    @property
    def above_background(self) -> float | None:
        """By how much the speech is louder than the background, dB."""
        return None if self.speech is None else self.speech - self.background


def obeyed_of_100(above: float) -> int | None:
    """Tell how many of 100 commands are obeyed by somebody who is so far above a room, dB.

    Returns:
        About so many; None if it was not measured, since few are.
    """
    return next((share for least, share in OBEYED_BY_SNR if above >= least), None)


def dbfs(samples: Samples | Floats) -> float:
    """Measure the mean power of some samples, dBFS; at least that of one unit."""
    return 10 * math.log10(float(np.mean(samples.astype(np.float64) ** 2)) + 1) - FULL_SCALE_DB


def measure_level(samples: Samples) -> RecordingLevel:
    """Measure a recording in which somebody should speak.

    Args:
        samples: at least one, 16 kHz; three seconds with a pause in them tell enough.
    """
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
    """Tell what is wrong with a recording, the worst first; nothing if it is fine."""
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
    """How likely each block is speech, however quiet it is: the network hears it made louder."""
    louder = sound * (0.5 * 32767 / np.abs(sound).max())
    return Silero().probabilities(louder.astype(np.int16)).astype(np.float64)


def _has_speech(voice: Floats) -> bool:
    if len(voice) < SYLLABLE_BLOCKS:
        return False
    means = np.convolve(voice, np.full(SYLLABLE_BLOCKS, 1 / SYLLABLE_BLOCKS), "valid")
    return bool(means.max() >= SPEECH_PROBABILITY)


def _background(frames: Floats, voice: Floats) -> float:
    """The power of most frames that are surely no speech, dBFS; else of the quietest tenth.

    Not the mean: now and then the network takes a syllable for background.
    """
    if not len(frames):
        return MIN_DBFS
    blocks = (np.arange(len(frames)) * ENERGY_FRAME + ENERGY_FRAME // 2) // SILERO_BLOCK
    inside = blocks < len(voice)
    quiet = frames[inside][voice[blocks[inside]] < NO_SPEECH_PROBABILITY]
    if len(quiet) < MIN_BACKGROUND_FRAMES:
        quiet = np.sort(frames)[: max(1, len(frames) // 10)]
    return float(np.median(quiet))
