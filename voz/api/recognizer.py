"""The recognizer of a program of one's own: of arrays, files and microphones."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from os import PathLike
from pathlib import Path

import numpy.typing as npt

from voz.api.listener import ARRAY, Blocks, Listener, utterances_of
from voz.api.microphone import MicrophoneUtterances, in_background
from voz.audio.sound_files import read_blocks, to_samples
from voz.errors import AudioError
from voz.events import Utterance
from voz.recognition.engine import MICROPHONE, RecognitionEngine, open_stream
from voz.recognition.interpreter import Details
from voz.records import check_callable, check_type


class Recognizer(RecognitionEngine):
    """Finds the utterances in arrays, files and microphones; made once, used for many.

    Any thread may call it; the calls take turns and do not affect each other. A signal handler that
    interrupts a call gets a `RecognizerBusyError`.
    """

    def listen(self, rate: float | None = None) -> Listener:
        """Begin a stream of arrays of a rate, Hz; AudioError if it is missing or too low."""
        return Listener(open_stream(self, ARRAY), rate)

    def decode(
        self,
        sound: str | PathLike[str] | npt.ArrayLike,
        rate: float | None = None,
        *,
        words: bool = False,
        best: int = 0,
    ) -> list[Utterance]:
        """Recognize a whole recording.

        Args:
            sound: a file of any format of libsndfile, or an array: samples, or samples x channels,
                int16 or floats from -1 to 1.
            rate: of an array, Hz; must be given.
            words: whether utterances have the times of their words.
            best: how many of the sentences that fit best they have, up to 100.

        Returns:
            The utterances by time.

        Raises:
            AudioError: the file cannot be read, the rate is missing, or the array holds something
                else.
            ConfigError: `words` or `best` is something else.
        """
        details = Details(words, best)
        if not isinstance(sound, str | PathLike):
            return list(self.utterances([to_samples(sound, rate)], ARRAY, details))
        if rate is not None:
            raise AudioError(f"{sound}: a file has its own rate; leave `rate` out")
        return list(self.utterances(read_blocks(Path(sound)), str(sound), details))

    def microphone(self, device: str | None = None) -> MicrophoneUtterances:
        """Listen to a microphone: iterate over what it returns.

        Args:
            device: its number or a part of its name, as `voz devices` prints them; None is the
                default one.

        Raises:
            AudioError: there is no such microphone.
        """
        check_type((str, type(None)), device, "device")
        return MicrophoneUtterances(self, open_stream(self, MICROPHONE, spotting=False), device)

    def listen_in_background(
        self, callback: Callable[[Utterance], None], device: str | None = None
    ) -> Callable[[], None]:
        """Listen to a microphone on a thread of its own.

        Args:
            callback: called on that thread with each utterance.
            device: as for `microphone`.

        Returns:
            A function that ends it; it raises the error by which it ended before, if any: that of
            the microphone or of the callback.

        Raises:
            AudioError: there is no such microphone.
        """
        check_callable(callback, "callback")
        return in_background(self.microphone(device), callback)

    def astream(self, blocks: Blocks, rate: float | None = None) -> AsyncIterator[Utterance]:
        """Recognize a stream for `async for`; the event loop goes on meanwhile.

        Args:
            blocks: arrays as for `decode`, by `async for` or by `for`, which then waits on a
                thread.
            rate: of the arrays, Hz; must be given.

        Raises:
            AudioError: the rate is missing, or a block holds something else.
        """
        return utterances_of(Listener(open_stream(self, ARRAY, spotting=False), rate), blocks)
