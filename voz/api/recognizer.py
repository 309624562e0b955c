"""The recognizer of a program of one's own: of arrays, files and microphones, also for asyncio."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import AsyncIterable, AsyncIterator, Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from os import PathLike
from pathlib import Path
from threading import Thread, current_thread
from typing import TYPE_CHECKING, Any

import numpy.typing as npt
from msgspec.structs import replace

from voz.audio.channels import OUT_OF_PHASE
from voz.audio.microphone import open_microphone
from voz.audio.sound_files import ArrayConverter, Warn, read_blocks, to_samples
from voz.errors import AudioError
from voz.events import Partial, Utterance
from voz.process.call_lock import NonReentrantLock
from voz.process.forks import ends_forks
from voz.recognition.engine import MICROPHONE, RecognitionEngine, open_stream
from voz.recognition.interpreter import Details
from voz.recognition.stream import Stream
from voz.records import PublicNames, check_callable, check_iterable, check_type

if TYPE_CHECKING:
    from voz.run.session import Session

_log = logging.getLogger("voz")

ARRAY = "array"
"""The `source` of utterances in arrays."""

Blocks = AsyncIterable[npt.ArrayLike] | Iterable[npt.ArrayLike]


class Listener(PublicNames):
    """A stream of arrays; `Recognizer.listen` makes one."""

    def __init__(self, stream: Stream, rate: float | None, warn: Warn = _log.warning) -> None:
        """Begin a stream of arrays of a rate, Hz; else as `ArrayConverter`."""
        check_type(Stream, stream, "stream")
        self._stream = stream
        self._converter = ArrayConverter(rate, warn)
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


async def utterances_of(listener: Listener, blocks: Blocks) -> AsyncIterator[Utterance]:
    """Yield the utterances of arrays while the event loop goes on."""
    import asyncio  # which takes 3 MB

    settled = SettledUtterances()
    if not isinstance(blocks, AsyncIterable):
        check_iterable(blocks, "blocks")
    async for block in blocks if isinstance(blocks, AsyncIterable) else _taken(blocks):
        for heard in settled.of(await asyncio.to_thread(listener.feed, block)):
            yield heard
    for heard in settled.of(await asyncio.to_thread(listener.finish)):
        yield heard


async def _taken(blocks: Iterable[npt.ArrayLike]) -> AsyncIterator[npt.ArrayLike]:
    """Wait for each block on a thread."""
    import asyncio

    iterator = iter(blocks)
    nothing: Any = object()
    while (block := await asyncio.to_thread(next, iterator, nothing)) is not nothing:
        yield block


class SettledUtterances:
    """Makes utterances of events, for whoever does not take a stop that was perhaps said.

    "stop stop stop" is heard as a `stop` at once, and in the end as no command. A live run halts at
    the first; here it becomes an utterance.
    """

    def __init__(self) -> None:
        self._perhaps: Partial | None = None

    def of(self, events: Iterable[Utterance | Partial]) -> Iterator[Utterance]:
        """Yield the utterances among the next events."""
        for event in events:
            if isinstance(event, Partial):
                self._perhaps = event
                continue
            perhaps, self._perhaps = self._perhaps, None
            yield _as_stop(event, perhaps) if perhaps and not event.accepted else event


def _as_stop(event: Utterance, perhaps: Partial) -> Utterance:
    said, sure = perhaps.text, perhaps.confidence
    return replace(
        event, text=said, command=perhaps.name, confidence=sure, accepted=True, reason=None,
        between=None, next_best=None, score=None, slots={}, perhaps=(),
    )  # fmt: skip


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

    @contextmanager
    def drive_session(self, session: Session) -> Iterator[None]:
        """Listen for a run, and open it again after each loss: a part of the run."""
        from voz.hearing.microphone_thread import Hearing, sound_card
        from voz.run.parts import hear_answers

        hearing = Hearing(
            self.recognizer, sound_card(self.device), session.inbox, session.clock.now,
            never_missed=session.table.stops,
        )  # fmt: skip
        with hearing, hear_answers(session, self.recognizer):
            session.watch_input(hearing)
            yield


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
