"""The HTTP server, on a thread of its own: its address, who may open it, and the link to it."""

from __future__ import annotations

import asyncio
import io
import ipaddress
import socket
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from ssl import SSLContext
from typing import Any

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from voz.apps.servers.command_bridge import EventQueue
from voz.apps.servers.connections import (
    PAGE_PLACES,
    SERVER_SHUTDOWN_TIMEOUT,
    ConnectionGuard,
    ListeningSocket,
    RateLimit,
    open_listening_socket,
)
from voz.apps.web.access_control import AccessControl, AccessMiddleware, new_token
from voz.apps.web.certificates import Certificates
from voz.apps.web.page_messages import Record
from voz.apps.web.page_registry import PageRegistry
from voz.errors import ConfigError, VozError

LOOPBACK_NAMES = ("localhost", "127.0.0.1", "::1")


@dataclass(frozen=True)
class PageAddress:
    """Where the page is served."""

    listener: ListeningSocket  # the socket that is listened on
    access: AccessControl  # who may open the page
    link: str  # what to open in a browser; it holds the token
    host: str  # the interface
    certificates: Certificates | None = None  # for HTTPS

    @property
    def tls(self) -> SSLContext | None:
        """The TLS context with the newest certificate; None for HTTP."""
        return self.certificates.context if self.certificates else None

    @property
    def authority(self) -> bytes | None:
        """The certificate that a phone has to trust, PEM; None for HTTP."""
        return self.certificates.authority if self.certificates else None

    def serving(
        self,
        app: ASGIApp,
        start_tasks: Callable[[], list[asyncio.Task[None]]],
        warn: Callable[[str], None],
    ) -> AbstractContextManager[None]:
        """Serve an application here, with access control, as `running_server` does."""
        guarded = AccessMiddleware(app, self.access, self.listener.guard)
        return running_server(guarded, self.listener, self.tls, start_tasks, warn)

    def renew_certificate(self) -> None:
        """Renew the certificate if it ends soon, or this computer has another address."""
        if self.certificates:
            self.certificates.renew(own_host_names(self.host), datetime.now(timezone.utc))


@contextmanager
def open_page_address(host: str, port: int, authority: Path | None) -> Iterator[PageAddress]:
    """Listen on the address of a page for a `with` block.

    `authority` is the folder of the certificate authority, for HTTPS; None for HTTP.

    Raises:
        ConfigError: the address cannot be bound, or the folder cannot be used.
    """
    token = None if is_local_host(host) else new_token()
    names = own_host_names(host)
    with open_page_socket(host, port) as listener:
        port = listener.getsockname()[1]
        access = AccessControl(names, token, f"voz-{port}")
        link = page_link(reachable_host(host), port, authority is not None, token)
        certificates = Certificates(authority) if authority else None
        address = PageAddress(listener, access, link, host, certificates)
        address.renew_certificate()
        yield address


def is_local_host(host: str) -> bool:
    """Whether only this computer itself can reach a host."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def own_host_names(host: str) -> list[str]:
    """List the names and addresses of a page on an interface; `0.0.0.0` and `::` are all."""
    name = socket.gethostname().lower()
    names = [*LOOPBACK_NAMES, host.lower()]
    if not is_local_host(host):
        names += [name, f"{name.partition('.')[0]}.local", *_addresses()]
    return list(dict.fromkeys(names))


def reachable_host(host: str) -> str:
    """Return the address to type on another computer."""
    if host not in ("0.0.0.0", "::"):
        return host
    return next(iter(_addresses()), "localhost")


def page_link(host: str, port: int, secure: bool, token: str | None) -> str:
    """Make the link to the page; what stands behind the # is never sent."""
    shown = f"[{host}]" if ":" in host else host
    scheme = "https" if secure else "http"
    return f"{scheme}://{shown}:{port}/" + (f"#token={token}" if token else "")


def qr_code(text: str) -> str:
    """Draw a QR code for a terminal."""
    import segno

    drawn = io.StringIO()
    segno.make(text, error="l", micro=False).terminal(out=drawn, compact=True, border=2)
    return drawn.getvalue().rstrip("\n")


def _addresses() -> Iterable[str]:
    """The source addresses of the default routes, then those that the host's name has."""
    found = []
    for family, far in ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1")):
        try:
            with socket.socket(family, socket.SOCK_DGRAM) as probe:
                probe.connect((far, 9))  # sends nothing: only the route is looked up
                found.append(str(probe.getsockname()[0]))
        except OSError:
            continue
    with suppress(OSError):
        found += [str(each[4][0]) for each in socket.getaddrinfo(socket.gethostname(), None)]
    return [address for address in dict.fromkeys(found) if not is_local_host(address)]


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
    """Serve an application on a socket for the length of a `with` block, by HTTPS with `tls`.

    `start_tasks` starts what else runs on the server's event loop. `warn` takes a line if the
    server fails; the run goes on without a page, and the driving page is gone (S5).
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
