"""Utterances in a stream of arrays, also for asyncio."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterable, AsyncIterator, Iterable, Iterator
from typing import Any

import numpy.typing as npt
from msgspec.structs import replace

from voz.audio.sound_files import ArrayConverter, Warn
from voz.events import Partial, Utterance
from voz.process.call_lock import NonReentrantLock
from voz.recognition.stream import Stream
from voz.records import PublicNames, check_iterable, check_type

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
