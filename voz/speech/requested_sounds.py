"""The sounds that a client requested and that have not ended, by key."""

from __future__ import annotations

import threading
from typing import TypeAlias

from voz.audio.mixer import Mixer
from voz.audio.playback import PlayingSound, Wave
from voz.errors import SpeechError, VozError
from voz.records import is_number

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
