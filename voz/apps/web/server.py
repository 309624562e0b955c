"""The server, on a thread of its own."""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from ssl import SSLContext

import uvicorn
from starlette.types import ASGIApp

from voz.apps.web.board import Record
from voz.apps.web.desk import Desk
from voz.apps.web.feed import Feed
from voz.apps.web.listener import ACCEPTED_AT_ONCE, ListeningSocket
from voz.apps.web.page_socket import PageSocket
from voz.errors import ConfigError, VozError

SHOWN_EVERY = 0.1
"""How often pages are told how things are, s."""

RENEWED_EVERY = 3600.0
"""How often it is looked after the certificate, s."""

MOST_AT_ONCE = 64
"""Messages of one page that wait to be looked at."""

LARGEST_MESSAGE = 32_768
"""Of a WebSocket, bytes: a block of sound has 3 kB."""

LARGEST_HEADER = 16_384
"""Of a request that is not complete yet, bytes: cookies of other services may be in it."""

CLOSING_TIME = 2.0
"""For the server to end, s; the robot is at rest by then."""


def listening_socket(host: str, port: int) -> ListeningSocket:
    """Take an address for the server, before anything moves.

    Args:
        host: the name or the address of an interface.
        port: its port; 0 takes any that is free.

    Raises:
        ConfigError: it cannot be had.
    """
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        with ExitStack() as failing:
            taken = failing.enter_context(ListeningSocket(family, kind, protocol))
            taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            taken.bind(address)
            taken.listen(ACCEPTED_AT_ONCE)
            failing.pop_all()
    except OSError as error:
        reason = error.strerror or str(error)
        raise ConfigError(
            f"the operator page cannot be at {host}, port {port} ({reason}); "
            "choose another with --web-host or --web-port"
        ) from None
    return taken


@contextmanager
def serving(
    app: ASGIApp,
    at: ListeningSocket,
    tls: SSLContext | None,
    work: Callable[[], list[asyncio.Task[None]]],
    warn: Callable[[str], None],
) -> Iterator[None]:
    """Serve an application for the length of a `with` block.

    Args:
        app: what answers.
        at: the socket that it listens at.
        tls: keys and certificates, for HTTPS.
        work: begins what else is to be done on the thread of the server.
        warn: told if it fails; the run goes on without a page, and who drove by it is gone (S5).
    """
    config = uvicorn.Config(
        app, http="h11", ws=PageSocket, ws_max_size=LARGEST_MESSAGE, ws_max_queue=MOST_AT_ONCE,
        ws_per_message_deflate=False, log_config=None, access_log=False, lifespan="off",
        proxy_headers=False, server_header=False, timeout_graceful_shutdown=1,
        backlog=ACCEPTED_AT_ONCE, h11_max_incomplete_event_size=LARGEST_HEADER,
    )  # fmt: skip
    config.load()
    config.ssl = tls
    server = uvicorn.Server(config)
    started = threading.Event()

    def serve() -> None:
        try:
            asyncio.run(_serve(server, at, work, started))
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
        thread.join(CLOSING_TIME)
        at.close()


async def _serve(
    server: uvicorn.Server,
    at: ListeningSocket,
    work: Callable[[], list[asyncio.Task[None]]],
    started: threading.Event,
) -> None:
    tasks = [*work(), asyncio.create_task(at.close_late())]
    for task in tasks:  # they have no end; one that fails shall not leave a page that stands still
        task.add_done_callback(lambda _: setattr(server, "should_exit", True))
    started.set()
    await server.serve(sockets=[at])
    for task in tasks:
        if task.done():
            task.result()
        task.cancel()


def telling(
    desk: Desk,
    feed: Feed,
    look: Callable[[], Record],
    news: Callable[[], list[Record]],
    renew: Callable[[], None],
) -> list[asyncio.Task[None]]:
    """Begin what is done all the time.

    Args:
        desk: tells pages what happens, and ten times a second how things are.
        feed: gives what happens.
        look: gives how things are.
        news: gives what else pages are to know, once.
        renew: looks after the certificate.
    """

    async def tell() -> None:
        async for event in feed.events():
            desk.take(event)

    async def show() -> None:
        while True:
            for record in news():
                desk.tell(record)
            desk.show(look())
            await asyncio.sleep(SHOWN_EVERY)

    async def keep() -> None:
        while True:
            await asyncio.sleep(RENEWED_EVERY)
            with suppress(VozError):  # the old one serves for a month yet
                await asyncio.to_thread(renew)

    return [asyncio.create_task(work) for work in (tell(), show(), keep())]
