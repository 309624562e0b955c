"""What both Wyoming servers share: an address, and connections that no client can misuse."""

from __future__ import annotations

import asyncio
import errno
import socket
import stat
from abc import abstractmethod
from collections.abc import AsyncIterator, Callable
from contextlib import ExitStack, asynccontextmanager, suppress
from pathlib import Path
from typing import ClassVar
from urllib.parse import urlparse

from wyoming.error import Error
from wyoming.event import Event, async_read_event
from wyoming.info import Attribution
from wyoming.server import AsyncEventHandler

from voz.apps.servers.connections import (
    IDLE_TIMEOUT,
    WYOMING_PLACES,
    ConnectionGuard,
    ListeningSocket,
    Peer,
    open_listening_socket,
)
from voz.errors import ConfigError, VozError

NO_SUCH_ADDRESS = (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT)
"""Why this computer has not all addresses of a name, as `localhost` without IPv6."""

LINGER_TIMEOUT = 5.0
"""For a client to read an error and close, s."""

DRAIN_BYTES = 1 << 16

ATTRIBUTION = Attribution("voz", "https://github.com/cmusphinx/pocketsphinx")


class BoundedReader(asyncio.StreamReader):
    """A stream that refuses large messages, so that no client can fill the memory."""

    def __init__(self, stream: asyncio.StreamReader, most: int) -> None:
        self._stream = stream
        self._most = most

    async def readline(self) -> bytes:
        """Read a line, of 64 KiB at most."""
        return await self._stream.readline()

    async def readexactly(self, n: int) -> bytes:
        """Read so many bytes; raises VozError if they are too many."""
        if n > self._most:
            raise VozError(f"an event has {n:,} bytes; send {self._most:,} at most")
        return await self._stream.readexactly(n)

    def feed_eof(self) -> None:
        """End the stream."""
        self._stream.feed_eof()


class Connection(AsyncEventHandler):
    """Answers one client, event by event."""

    max_bytes: ClassVar[int]  # of the data and the payload of one event

    def __init__(
        self, guard: ConnectionGuard, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        super().__init__(BoundedReader(reader, self.max_bytes), writer)
        self._stream = reader
        self._guard = guard
        self.peer: Peer = writer.get_extra_info("peername")[:2]  # where the client is

    async def run(self) -> None:
        """Answer until the client goes, sends something invalid, or is closed by the guard."""
        task = asyncio.current_task()

        def end() -> None:
            if task:
                task.cancel()
            self.writer.transport.abort()

        self._guard.close_by(self.peer, end)
        wrong = (ValueError, KeyError, TypeError, AttributeError, RecursionError)
        try:
            with suppress(*wrong, OSError, EOFError, asyncio.TimeoutError):
                if await self._ends_by_error():
                    await self._close_after_client()
        finally:
            self.writer.close()

    async def _ends_by_error(self) -> bool:
        """Answer until the client goes, or is sent an error that ends it; returns which it was."""
        try:
            while event := await async_read_event(self.reader):
                if not await self.handle_event(event):
                    return True
        except VozError as error:  # more bytes than are read
            await self.write_error(error)
            return True
        return False

    async def write_error(self, error: VozError) -> None:
        """Send an error."""
        await self.write_event(Error(str(error), code="voz").event())

    async def _close_after_client(self) -> None:
        """Take what the client still sends: else TCP would reset what it has not read yet."""
        if self.writer.can_write_eof():
            self.writer.write_eof()
        with suppress(asyncio.TimeoutError):
            await asyncio.wait_for(self._drain_input(), LINGER_TIMEOUT)

    async def _drain_input(self) -> None:
        while await self._stream.read(DRAIN_BYTES):
            pass

    async def handle_event(self, event: Event) -> bool:
        """Answer an event; returns whether there may be more."""
        with self._guard.answering(self.peer):
            try:
                await self.answer(event)
            except VozError as error:
                await self.write_error(error)
                return False
            return True

    async def write_event(self, event: Event) -> None:
        """Send an event; a client that does not take it is closed."""
        try:
            await asyncio.wait_for(super().write_event(event), IDLE_TIMEOUT)
        except asyncio.TimeoutError:
            self.writer.transport.abort()
            raise

    @abstractmethod
    async def answer(self, event: Event) -> None:
        """Answer an event; a VozError that it raises is told to the client, and ends it."""


ConnectionMaker = Callable[
    [ConnectionGuard, asyncio.StreamReader, asyncio.StreamWriter], Connection
]
"""Makes what answers a client."""


@asynccontextmanager
async def serving(uri: str, make: ConnectionMaker) -> AsyncIterator[None]:
    """Answer clients at an address for a `with` block; raises ConfigError if that cannot be."""
    guard = ConnectionGuard(WYOMING_PLACES)
    tasks: set[asyncio.Task[None]] = set()

    def connected(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.create_task(make(guard, reader, writer).run())
        tasks.add(task)  # the event loop holds no reference
        task.add_done_callback(tasks.discard)

    try:
        listeners = _listen(guard, uri)
        backlog = guard.places.backlog
        servers = [
            await asyncio.start_server(connected, sock=listener, backlog=backlog)
            for listener in listeners
        ]
    except (ValueError, OSError) as error:
        raise ConfigError(
            f"--wyoming {uri}: cannot listen there ({error}); name tcp://HOST:PORT or unix://FILE"
        ) from None
    tasks.add(asyncio.create_task(guard.close_idle()))
    try:
        yield
    finally:
        for server in servers:
            server.close()
        for task in tasks:
            task.cancel()
        if uri.startswith("unix://"):
            Path(urlparse(uri).path).unlink(missing_ok=True)


def _listen(guard: ConnectionGuard, uri: str) -> list[ListeningSocket]:
    """Listen at all addresses of a URI; raises OSError or ValueError if that cannot be."""
    link = urlparse(uri)
    if link.scheme == "unix" and link.path:
        return [_listen_at_file(guard, Path(link.path))]
    if link.scheme != "tcp" or link.hostname is None or link.port is None:
        raise ValueError("invalid address")
    found = socket.getaddrinfo(
        link.hostname, link.port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
    )
    missing: OSError | None = None
    with ExitStack() as failing:
        listeners = []
        for family, _, protocol, _, address in dict.fromkeys(found):
            try:
                listener = open_listening_socket(guard, family, protocol, address)
            except OSError as error:
                if error.errno not in NO_SUCH_ADDRESS:
                    raise
                missing = error
            else:
                listeners.append(failing.enter_context(listener))
        if missing and not listeners:
            raise missing
        failing.pop_all()
    return listeners


def _listen_at_file(guard: ConnectionGuard, path: Path) -> ListeningSocket:
    """Listen at a file, which may be there from a run before; another one is not touched."""
    with suppress(FileNotFoundError):
        if stat.S_ISSOCK(path.lstat().st_mode):
            path.unlink()
    return open_listening_socket(guard, socket.AF_UNIX, 0, str(path))
