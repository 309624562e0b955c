"""Utterances in a stream of arrays."""

from __future__ import annotations

import numpy.typing as npt

from voz.audio.sound_files import ArrayConverter
from voz.events import Partial, Utterance
from voz.recognition.call_lock import NonReentrantLock
from voz.recognition.stream import Stream
from voz.records import PublicNames, check_type


class Listener(PublicNames):
    """A stream of arrays; `Recognizer.listen` makes one."""

    def __init__(self, stream: Stream, rate: float | None) -> None:
        """Begin a stream of arrays of a rate, Hz; errors are those of `ArrayConverter`."""
        check_type(Stream, stream, "stream")
        self._stream = stream
        self._converter = ArrayConverter(rate)
        self._lock = NonReentrantLock()

    def feed(self, array: npt.ArrayLike) -> list[Utterance | Partial]:
        """Take the next array; returns new utterances, and a possible `stop` at once.

        Args:
            array: samples, or samples x channels, of any length: int16, or floats from -1 to 1.

        Raises:
            AudioError: the array holds something else, or the stream was ended.
        """
        with self._lock:
            return list(self._stream.feed(self._converter.feed(array)))

    def finish(self) -> list[Utterance | Partial]:
        """End the stream; returns what was still open."""
        with self._lock:
            last = self._stream.feed(self._converter.finish())
            return [*last, *self._stream.finish()]
