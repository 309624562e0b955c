"""Sounds without words, synthesized from sines, with the numbers of ROS sound_play."""

from __future__ import annotations

import enum
import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from voz.audio.playback import PLAYBACK_RATE, Wave
from voz.errors import SpeechError
from voz.printable import shown_value

ALL = -1
"""Stops all sounds."""

AMPLITUDE = 0.5
"""Loud enough beside a voice; two at once need not be turned down."""

ATTACK_SECONDS = 0.008
"""A shorter attack clicks."""


class BuiltinSound(enum.IntEnum):
    """The built-in sounds; another number raises SpeechError."""

    BACKINGUP = 1
    NEEDS_UNPLUGGING = 2
    NEEDS_PLUGGING = 3
    NEEDS_UNPLUGGING_BADLY = 4
    NEEDS_PLUGGING_BADLY = 5

    @classmethod
    def _missing_(cls, value: object) -> NoReturn:
        known = f"1 to {len(cls)}"
        raise SpeechError(f"there is no built-in sound {shown_value(value)}; give {known}")

    @property
    def title(self) -> str:
        """Its name on the command line, as `backing-up`."""
        name = "backing_up" if self is BuiltinSound.BACKINGUP else self.name.lower()
        return name.replace("_", "-")


@dataclass(frozen=True)
class _Note:
    """A tone: Hz, seconds until the next, and brightness, 0 to 1."""

    frequency: float
    seconds: float
    brightness: float


C, E, G, HIGH_C = 523.25, 659.26, 783.99, 1046.5
LONG_REST = _Note(0.0, 0.5, 0.0)
SHORT_REST = _Note(0.0, 0.15, 0.0)

MELODIES: dict[BuiltinSound, Sequence[_Note]] = {
    # A lorry's: one tone, again and again.
    BuiltinSound.BACKINGUP: [_Note(950.0, 0.35, 0.3), _Note(0.0, 0.35, 0.0)],
    # Power is there: it goes up.
    BuiltinSound.NEEDS_UNPLUGGING: [_Note(C, 0.2, 0.2), _Note(G, 0.4, 0.2), LONG_REST],
    # Power goes out: it goes down.
    BuiltinSound.NEEDS_PLUGGING: [_Note(E, 0.25, 0.2), _Note(C, 0.5, 0.2), LONG_REST],
    # The same, higher, brighter, and three times in a hurry.
    BuiltinSound.NEEDS_UNPLUGGING_BADLY: [
        *(3 * [_Note(G, 0.08, 0.8), _Note(HIGH_C, 0.13, 0.8)]),
        SHORT_REST,
    ],
    BuiltinSound.NEEDS_PLUGGING_BADLY: [
        *(3 * [_Note(HIGH_C, 0.1, 0.8), _Note(E, 0.16, 0.8)]),
        SHORT_REST,
    ],
}


@functools.cache
def synthesize_sound(sound: BuiltinSound) -> Wave:
    """Return the samples at `PLAYBACK_RATE`, with silence at both ends for repeating."""
    return np.concatenate([_tone(note) for note in MELODIES[sound]])


def _tone(note: _Note) -> Wave:
    """Synthesize a decaying note; bright ones sound like a reed, others like a bell."""
    time = np.arange(round(note.seconds * PLAYBACK_RATE)) / PLAYBACK_RATE
    harmonics = [note.brightness ** (k - 1) / k for k in (1, 2, 3, 4)]
    wave = sum(
        strength * np.sin(2 * np.pi * k * note.frequency * time)
        for k, strength in enumerate(harmonics, 1)
    )
    swell = np.minimum(1, time / ATTACK_SECONDS) * np.minimum(
        1, (note.seconds - time) / ATTACK_SECONDS
    )
    dying = np.exp(-time / (0.4 + note.brightness))
    tone: Wave = (AMPLITUDE / sum(harmonics) * wave * swell * dying).astype(np.float32)
    return tone
