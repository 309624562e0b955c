"""Utterances as they are said into a microphone, also in the background."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from threading import Thread, current_thread

from voz.api.listener import SettledUtterances
from voz.audio.channels import OUT_OF_PHASE
from voz.audio.microphone import open_microphone
from voz.errors import AudioError
from voz.events import Utterance
from voz.process.forks import ends_forks
from voz.recognition.engine import RecognitionEngine
from voz.recognition.stream import Stream
from voz.records import PublicNames

_log = logging.getLogger("voz")

BACKGROUND_JOIN_TIMEOUT = 5.0
"""For a callback to return after the end, s."""


class MicrophoneUtterances(PublicNames):
    """Iterates over what is said into a microphone; `Recognizer.microphone` makes one.

    It listens from when it is made until it is closed, or its `with` block ends.

    Attributes:
        recognizer: which made it.
        device: its number or a part of its name; None is the default one.
        name: the whole name.
    """

    def __init__(self, recognizer: RecognitionEngine, stream: Stream, device: str | None) -> None:
        """Open a microphone; raises AudioError if there is no such microphone."""
        self.recognizer = recognizer
        self.device = device
        self._stream = stream
        self._opened = ExitStack()
        self._blocks = self._opened.enter_context(open_microphone(device))
        self.name = self._blocks.name
        self._heard: deque[Utterance] = deque()
        self._settled = SettledUtterances()
        self._closed = False
        self._out_of_phase = False  # whether that was told

    def __enter__(self) -> MicrophoneUtterances:
        """Itself."""
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> Iterator[Utterance]:
        return self

    def __next__(self) -> Utterance:
        """Wait for the next utterance; raises AudioError when the microphone is lost."""
        while not self._heard:
            try:
                block = next(self._blocks)
            except AudioError:
                if not self._closed:
                    self.close()
                    raise
            if self._closed:
                raise StopIteration
            if self._blocks.out_of_phase and not self._out_of_phase:
                self._out_of_phase = True
                _log.warning("microphone: %s", OUT_OF_PHASE)
            self._heard += self._settled.of(self._stream.feed(block))
        return self._heard.popleft()

    def close(self) -> None:
        """Close the microphone, on any thread; the iteration ends."""
        self._closed = True
        self._opened.close()


def in_background(
    utterances: MicrophoneUtterances, callback: Callable[[Utterance], None]
) -> Callable[[], None]:
    """Call a function with each utterance, on a thread of its own; returns what ends that.

    What ends it raises the error by which it ended before: of the microphone, or of the function.
    """
    failures: list[BaseException] = []

    def work() -> None:
        try:
            for heard in utterances:
                with ends_forks():
                    callback(heard)
        except BaseException as error:  # `sys.exit` in the function, too: nobody listens any more
            failures.append(error)
            _log.error("the microphone is not listened to any more: %s", str(error) or repr(error))
            utterances.close()

    thread = Thread(target=work, name="voz-background", daemon=True)

    def stop() -> None:
        utterances.close()
        if thread is not current_thread():  # the function may end it itself
            thread.join(BACKGROUND_JOIN_TIMEOUT)
        if failures:
            raise failures[0]

    thread.start()
    return stop
