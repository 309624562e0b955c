"""Follows a stream of arrays of one's own."""

from __future__ import annotations

import numpy.typing as npt

from voz.audio.capture.arrays import ArrayConverter
from voz.events import Partial, Utterance
from voz.recognition.call_lock import NonReentrantLock
from voz.recognition.stream import Stream


class Listener:
    """Hears a stream of sound in arrays; `Recognizer.listen` makes one."""

    def __init__(self, stream: Stream, rate: float | None) -> None:
        """Begin to listen; errors are those of `ArrayConverter`.

        Args:
            stream: what understands it.
            rate: of all arrays, Hz.
        """
        self._stream = stream
        self._converter = ArrayConverter(rate)
        self._turns = NonReentrantLock()

    def feed(self, array: npt.ArrayLike) -> list[Utterance | Partial]:
        """Take the next sound.

        Args:
            array: samples, or samples x channels, of any length: int16, or floats from -1 to 1.

        Returns:
            What is known by it, most often nothing: utterances, and what may be a `stop` at once.

        Raises:
            AudioError: it is something else, or the stream was ended.
        """
        with self._turns:
            return list(self._stream.feed(self._converter.feed(array)))

    def finish(self) -> list[Utterance | Partial]:
        """End the stream; returns what was still open."""
        with self._turns:
            last = self._stream.feed(self._converter.finish())
            return [*last, *self._stream.finish()]
