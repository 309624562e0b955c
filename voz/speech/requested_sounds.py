"""What a sound client was asked for and is still to be heard, known by what it is stopped by."""

from __future__ import annotations

import threading
from typing import TypeAlias

from voz.audio.playback.mixer import Mixer
from voz.audio.playback.playing_sound import PlayingSound, Wave
from voz.errors import SpeechError, VozError
from voz.records import is_number

SoundKey: TypeAlias = tuple[str, ...]
"""The kind of a sound, then what it is: its name, its path, or its text and voice."""


class RequestedSound:
    """One sound that was asked for, and its way to the loudspeaker once it has begun.

    Args:
        volume: 0 to 1; what is beyond is taken as that.
        repeats: whether it goes on until it is stopped.

    Raises:
        SpeechError: the volume is no number.
    """

    def __init__(self, volume: float, repeats: bool) -> None:
        if not is_number(volume):
            raise SpeechError(f"a volume is a number from 0 to 1, and no {type(volume).__name__}")
        self.volume = min(max(0.0, volume), 1.0)  # in this order NaN is silence
        self.repeats = repeats
        self.error: VozError | None = None
        self.decided = threading.Event()  # it has begun, or never will
        self.source: PlayingSound | None = None

    @property
    def over(self) -> bool:
        """Whether it is not to be heard any more."""
        return self.decided.is_set() and (self.source is None or self.source.over)


class RequestedSounds:
    """All that is to be heard, one of each key; may be used from several threads.

    Args:
        mixer: where they are heard.
    """

    def __init__(self, mixer: Mixer) -> None:
        self._mixer = mixer
        self._lock = threading.Lock()
        self._orders: dict[SoundKey, RequestedSound] = {}
        self._closed = False

    def place(self, key: SoundKey, volume: float, repeats: bool) -> RequestedSound:
        """Take note of a sound that is to begin, in the place of what has the same key."""
        order = RequestedSound(volume, repeats)
        self.stop(key)
        with self._lock:
            if self._closed:
                order.decided.set()
            self._orders = {k: o for k, o in self._orders.items() if not o.over}
            self._orders[key] = order
        return order

    def begin(self, order: RequestedSound, wave: Wave) -> None:
        """Let a sound be heard, unless it was stopped meanwhile."""
        with self._lock:
            if not order.decided.is_set():
                order.source = self._mixer.play(wave, order.volume, order.repeats)
                order.decided.set()

    def fail(self, order: RequestedSound, error: VozError) -> bool:
        """Give a sound up; False if it was stopped meanwhile, so that nobody cares."""
        with self._lock:
            if order.decided.is_set():
                return False
            order.error = error
            order.decided.set()
            return True

    def stop(self, beginning: SoundKey = ()) -> None:
        """End all whose keys begin so."""
        with self._lock:
            for key, order in self._orders.items():
                if key[: len(beginning)] == beginning:
                    order.decided.set()
                    if order.source:
                        self._mixer.stop(order.source)

    def wait(self, order: RequestedSound) -> None:
        """Wait until a sound has ended, and raise what kept it from being heard."""
        order.decided.wait()
        if order.source:
            self._mixer.wait(order.source)
        if order.error:
            raise order.error

    def heard_once(self) -> list[RequestedSound]:
        """Give what ends by itself."""
        with self._lock:
            return [order for order in self._orders.values() if not order.repeats]

    def close(self) -> None:
        """End all, and let nothing begin any more."""
        with self._lock:
            self._closed = True
        self.stop()
