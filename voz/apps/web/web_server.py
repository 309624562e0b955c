"""The HTTP server, on a thread of its own."""

from __future__ import annotations

import asyncio
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from ssl import SSLContext
from typing import Any

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from voz.apps.servers.connections import (
    PAGE_PLACES,
    ConnectionGuard,
    ListeningSocket,
    open_listening_socket,
)
from voz.apps.servers.rate_limits import RateLimit
from voz.apps.web.event_history import Record
from voz.apps.web.event_queue import EventQueue
from voz.apps.web.page_registry import PageRegistry
from voz.errors import ConfigError, VozError

STATE_INTERVAL = 0.1
"""How often pages are sent the state, s."""

CERTIFICATE_CHECK_INTERVAL = 3600.0
"""How often the certificate is renewed if need be, s."""

MAX_UNREAD_MESSAGES = 64
"""Messages of one page that wait to be read."""

MAX_MESSAGE_BYTES = 32_768
"""Of a WebSocket: a block of sound has 3 kB."""

MAX_HEADER_BYTES = 16_384
"""Of a request: cookies of other services may be in it."""

SERVER_SHUTDOWN_TIMEOUT = 2.0
"""For the server to end, s; the robot is at rest by then."""


FRAME_RATE, FRAME_BURST = 200.0, 1000.0
"""Frames of one page per second, and at once; its sound is 50 blocks a second."""

READ_SLICE = 4096
"""Bytes that are read before the frames are counted: the smallest frame has 6."""


class RateLimitedWebSocket(WebSocketsSansIOProtocol):
    """Closes the connection of a page that sends too many frames.

    uvicorn answers each ping at once, however many answers wait to be read, and the application,
    which limits messages, sees neither pings nor empty parts of messages.
    """

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        self._limit = RateLimit(FRAME_RATE, FRAME_BURST)

    def data_received(self, data: bytes) -> None:
        """Read what came; a flood is noticed before all of it is read."""
        for start in range(0, len(data), READ_SLICE):
            if not self.transport.is_closing():
                super().data_received(data[start : start + READ_SLICE])

    def handle_events(self) -> None:
        """Handle the frames that were read, or end the connection if there are too many."""
        if self._limit.allows(time.monotonic(), len(self.conn.events)):
            super().handle_events()
        else:
            self.transport.abort()


def open_page_socket(host: str, port: int) -> ListeningSocket:
    """Bind the server's address, before anything moves; port 0 is any that is free.

    Raises:
        ConfigError: the address cannot be bound.
    """
    try:
        family, _, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        return open_listening_socket(ConnectionGuard(PAGE_PLACES), family, protocol, address)
    except OSError as error:
        reason = error.strerror or str(error)
        raise ConfigError(
            f"the operator page cannot be at {host}, port {port} ({reason}); "
            "choose another with --web-host or --web-port"
        ) from None


@contextmanager
def running_server(
    app: ASGIApp,
    listener: ListeningSocket,
    tls: SSLContext | None,
    start_tasks: Callable[[], list[asyncio.Task[None]]],
    warn: Callable[[str], None],
) -> Iterator[None]:
    """Serve an application for the length of a `with` block.

    Args:
        app: the application.
        listener: the socket that is listened on.
        tls: keys and certificates, for HTTPS.
        start_tasks: starts what else runs on the server's event loop.
        warn: takes a line if the server fails; the run goes on without a page, and the driving
            page is gone (S5).
    """
    config = uvicorn.Config(
        app, http="h11", ws=RateLimitedWebSocket, ws_max_size=MAX_MESSAGE_BYTES,
        ws_max_queue=MAX_UNREAD_MESSAGES, ws_per_message_deflate=False, log_config=None,
        access_log=False, lifespan="off", proxy_headers=False, server_header=False,
        timeout_graceful_shutdown=1, backlog=listener.guard.places.backlog,
        h11_max_incomplete_event_size=MAX_HEADER_BYTES,
    )  # fmt: skip
    config.load()
    config.ssl = tls
    server = uvicorn.Server(config)
    started = threading.Event()

    def serve() -> None:
        try:
            asyncio.run(_serve(server, listener, start_tasks, started))
        except BaseException as error:  # whatever it is: the robot goes on
            warn(f"the operator page has failed ({error!r})")
        finally:
            started.set()

    thread = threading.Thread(target=serve, name="voz-web", daemon=True)
    thread.start()
    started.wait()
    try:
        yield
    finally:
        server.should_exit = True
        thread.join(SERVER_SHUTDOWN_TIMEOUT)
        listener.close()


async def _serve(
    server: uvicorn.Server,
    listener: ListeningSocket,
    start_tasks: Callable[[], list[asyncio.Task[None]]],
    started: threading.Event,
) -> None:
    tasks = [*start_tasks(), asyncio.create_task(listener.guard.close_idle())]
    for task in tasks:  # they have no end; if one fails, no page shall stay that shows an old state
        task.add_done_callback(lambda _: setattr(server, "should_exit", True))
    started.set()
    await server.serve(sockets=[listener])
    for task in tasks:
        if task.done():
            task.result()
        task.cancel()


def start_background_tasks(
    registry: PageRegistry,
    events: EventQueue,
    state: Callable[[], Record],
    new_records: Callable[[], list[Record]],
    renew_certificate: Callable[[], None],
) -> list[asyncio.Task[None]]:
    """Start what sends events, states and new records to the pages, and renews the certificate."""

    async def publish_events() -> None:
        async for event in events.events():
            registry.publish(event)

    async def broadcast_states() -> None:
        while True:
            for record in new_records():
                registry.broadcast(record)
            registry.broadcast_state(state())
            await asyncio.sleep(STATE_INTERVAL)

    async def renew_certificates() -> None:
        while True:
            await asyncio.sleep(CERTIFICATE_CHECK_INTERVAL)
            with suppress(VozError):  # the old one is valid for another month
                await asyncio.to_thread(renew_certificate)

    work = (publish_events(), broadcast_states(), renew_certificates())
    return [asyncio.create_task(each) for each in work]
