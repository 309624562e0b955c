"""Sounds: the built-in ones without words, and those that a client requested and that go on."""

from __future__ import annotations

import enum
import functools
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn, TypeAlias

import numpy as np

from voz.audio.mixer import Mixer
from voz.audio.playback import PLAYBACK_RATE, PlayingSound, Wave
from voz.errors import SpeechError, VozError
from voz.printable import shown_value
from voz.records import is_number

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


SoundKey: TypeAlias = tuple[str, ...]
"""The kind of a sound, then its name, its path, or its text and voice."""

SPOKEN = "voice"
"""The kind of speech."""


class RequestedSound:
    """A requested sound, and the playing one once it has begun.

    Args:
        volume: limited to 0 to 1.
        repeats: whether it repeats until it is stopped.
        text: what it says, if it is speech.

    Raises:
        SpeechError: the volume is no number.
    """

    def __init__(self, volume: float, repeats: bool, text: str | None = None) -> None:
        if not is_number(volume):
            raise SpeechError(f"a volume is a number from 0 to 1, and no {type(volume).__name__}")
        self.volume = min(max(0.0, volume), 1.0)  # in this order NaN is silence
        self.repeats = repeats
        self.text = text
        self.error: VozError | None = None
        self.decided = threading.Event()  # it has begun, or never will
        self.source: PlayingSound | None = None

    @property
    def over(self) -> bool:
        """Whether it will not be heard any more."""
        return self.decided.is_set() and (self.source is None or self.source.over)


class RequestedSounds:
    """All requested sounds, one of each key; thread-safe."""

    def __init__(self, mixer: Mixer) -> None:
        self._mixer = mixer
        self._lock = threading.Lock()
        self._sounds: dict[SoundKey, RequestedSound] = {}
        self._closed = False

    def add(self, key: SoundKey, volume: float, repeats: bool) -> RequestedSound:
        """Add a sound that is to begin; it replaces the one with the same key."""
        sound = RequestedSound(volume, repeats, key[1] if key[0] == SPOKEN else None)
        self.stop(key)
        with self._lock:
            if self._closed:
                sound.decided.set()
            self._sounds = {k: one for k, one in self._sounds.items() if not one.over}
            self._sounds[key] = sound
        return sound

    def begin(self, sound: RequestedSound, wave: Wave) -> None:
        """Play a sound, unless it was stopped meanwhile."""
        with self._lock:
            if not sound.decided.is_set():
                sound.source = self._mixer.play(wave, sound.volume, sound.repeats, sound.text)
                sound.decided.set()

    def fail(self, sound: RequestedSound, error: VozError) -> bool:
        """Note that a sound cannot be played; returns False if it was stopped meanwhile."""
        with self._lock:
            if sound.decided.is_set():
                return False
            sound.error = error
            sound.decided.set()
            return True

    def stop(self, beginning: SoundKey = ()) -> None:
        """Stop all sounds whose keys begin like this."""
        with self._lock:
            for key, sound in self._sounds.items():
                if key[: len(beginning)] == beginning:
                    sound.decided.set()
                    if sound.source:
                        self._mixer.stop(sound.source)

    def wait(self, sound: RequestedSound) -> None:
        """Wait until a sound has ended; raises the error that prevented it."""
        sound.decided.wait()
        if sound.source:
            self._mixer.wait(sound.source)
        if sound.error:
            raise sound.error

    def without_repeating(self) -> list[RequestedSound]:
        """The sounds that do not repeat."""
        with self._lock:
            return [sound for sound in self._sounds.values() if not sound.repeats]

    def close(self) -> None:
        """Stop all sounds, and start no more."""
        with self._lock:
            self._closed = True
        self.stop()
