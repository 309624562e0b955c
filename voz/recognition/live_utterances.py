"""Utterances as they are said: of a microphone, in the background, and for asyncio."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import AsyncIterable, AsyncIterator, Callable, Iterable, Iterator
from contextlib import ExitStack
from threading import Thread, current_thread
from typing import TYPE_CHECKING, Any

import numpy.typing as npt
from msgspec.structs import replace

from voz.audio.microphone import open_microphone
from voz.errors import AudioError
from voz.events import Partial, Utterance
from voz.process.forks import ends_forks
from voz.recognition.listener import Listener
from voz.recognition.stream import Stream
from voz.records import PublicNames, check_iterable

if TYPE_CHECKING:
    from voz.recognition.recognizer import Recognizer

_log = logging.getLogger("voz")

BACKGROUND_JOIN_TIMEOUT = 5.0
"""For a callback to return after the end, s."""

Blocks = AsyncIterable[npt.ArrayLike] | Iterable[npt.ArrayLike]


class MicrophoneUtterances(PublicNames):
    """Iterates over what is said into a microphone; `Recognizer.microphone` makes one.

    It listens from when it is made until it is closed, or its `with` block ends.

    Attributes:
        recognizer: which made it.
        device: its number or a part of its name; None is the default one.
        name: the whole name.
    """

    def __init__(self, recognizer: Recognizer, stream: Stream, device: str | None) -> None:
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
