"""What both Wyoming servers share: an address, and connections that no client can misuse."""

from __future__ import annotations

import asyncio
from abc import abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from wyoming.error import Error
from wyoming.event import Event
from wyoming.info import Attribution
from wyoming.server import AsyncEventHandler, AsyncServer

from voz.errors import ConfigError, VozError

MAX_PAYLOAD_BYTES = 4_000_000
"""Of one message: half a minute of sound at 48 kHz."""

ATTRIBUTION = Attribution("voz", "https://github.com/cmusphinx/pocketsphinx")


class BoundedReader(asyncio.StreamReader):
    """A stream that refuses large messages, so that no client can fill the memory."""

    def __init__(self, stream: asyncio.StreamReader) -> None:
        self._stream = stream

    async def readline(self) -> bytes:
        """Read a line, of 64 KiB at most."""
        return await self._stream.readline()

    async def readexactly(self, n: int) -> bytes:
        """Read so many bytes; raises ValueError if they are too many."""
        if n > MAX_PAYLOAD_BYTES:
            raise ValueError(f"{n} bytes are too many")
        return await self._stream.readexactly(n)

    def feed_eof(self) -> None:
        """End the stream."""
        self._stream.feed_eof()


class Connection(AsyncEventHandler):
    """Answers one client, event by event."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        super().__init__(BoundedReader(reader), writer)

    async def run(self) -> None:
        """Answer until the client goes, or sends something invalid."""
        with suppress(ValueError, KeyError, TypeError, AttributeError, OSError, EOFError):
            await super().run()
        self.writer.close()

    async def handle_event(self, event: Event) -> bool:
        """Answer an event; returns whether there may be more."""
        try:
            await self.answer(event)
        except VozError as error:
            await self.write_event(Error(str(error), code="voz").event())
            return False
        return True

    @abstractmethod
    async def answer(self, event: Event) -> None:
        """Answer an event; a VozError that it raises is told to the client, and ends it."""


@contextmanager
def opening(uri: str) -> Iterator[AsyncServer]:
    """Make the server of an address; in the `with` block an error of it is a ConfigError."""
    try:
        if not uri.startswith(("tcp://", "unix://")):
            raise ValueError("invalid address")
        yield AsyncServer.from_uri(uri)
    except (ValueError, OSError) as error:
        raise ConfigError(
            f"--wyoming {uri}: cannot listen there ({error}); name tcp://HOST:PORT or unix://FILE"
        ) from None
