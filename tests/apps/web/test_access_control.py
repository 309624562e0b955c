"""Who may come in: whoever has the token, whatever else is connected."""

from __future__ import annotations

import socket
import ssl
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from datetime import datetime, timezone
from pathlib import Path

import httpx
import pytest
from programs import PATIENCE
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket
from websockets.sync.client import connect

from voz.apps.servers import connections
from voz.apps.servers.connections import PAGE_PLACES
from voz.apps.web import access_control
from voz.apps.web.access_control import AccessControl, AccessMiddleware
from voz.apps.web.certificates import Certificates
from voz.apps.web.web_server import open_page_socket, running_server

TOKEN = "secret"
BEARER = {"Authorization": f"Bearer {TOKEN}"}

MANY = 2 * PAGE_PLACES.idle + 50

HEAD = b"POST /api/login HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 100\r\n\r\n"


async def body(request: Request) -> Response:
    return Response(await request.body())


async def echo(socket: WebSocket) -> None:
    await socket.accept()
    async for text in socket.iter_text():
        await socket.send_text(text)


@contextmanager
def served(tls: ssl.SSLContext | None = None) -> Iterator[int]:
    """A server that needs the token; yields its port."""
    routes = [
        Route("/", lambda _: PlainTextResponse("page")),
        Route("/file", lambda _: FileResponse(__file__)),
        Route("/api/login", body, methods=["POST"]),
        Route("/api/stop", body, methods=["POST"]),
        WebSocketRoute("/api/events", echo),
    ]
    with open_page_socket("127.0.0.1", 0) as at:
        app = AccessMiddleware(Starlette(routes=routes), AccessControl([], TOKEN), at.guard)
        with running_server(app, at, tls, list, lambda _: None):
            yield at.getsockname()[1]


@contextmanager
def connected(port: int, data: bytes = b"", host: str = "127.0.0.1") -> Iterator[socket.socket]:
    """A connection from an address of this computer, on which something was sent."""
    with socket.create_connection(("127.0.0.1", port), PATIENCE, (host, 0)) as connection:
        connection.sendall(data)
        yield connection


def crowd(
    port: int, data: bytes = b"", scheme: str = "http"
) -> Iterator[AbstractContextManager[socket.socket]]:
    """More connections than may wait, as fast as they are accepted."""
    for number in range(MANY):
        if number % 50 == 0:  # else the system's own queue is full, and one waits a second
            assert asks_to_stop(port, scheme, **BEARER) == 200
        yield connected(port, data)


def asks_to_stop(port: int, scheme: str = "http", **headers: str) -> int:
    with httpx.Client(verify=False, timeout=PATIENCE, headers=headers) as client:
        return client.post(f"{scheme}://127.0.0.1:{port}/api/stop").status_code


@pytest.fixture(scope="module")
def tls(tmp_path_factory: pytest.TempPathFactory) -> ssl.SSLContext:
    certificates = Certificates(tmp_path_factory.mktemp("authority"))
    certificates.renew(["127.0.0.1"], datetime.now(timezone.utc))
    return certificates.context


@pytest.mark.parametrize(
    "data", [b"", b"POST /api/st", HEAD, HEAD + b"{"], ids=["nothing", "half", "head", "body"]
)
def test_connections_without_the_token_keep_nobody_out(data: bytes) -> None:
    with served() as port, ExitStack() as stack:
        first, *_ = map(stack.enter_context, crowd(port, data))
        assert asks_to_stop(port, **BEARER) == 200
        assert first.recv(1) == b""


def test_tls_handshakes_without_an_end_keep_nobody_out(tls: ssl.SSLContext) -> None:
    with served(tls) as port, ExitStack() as stack:
        first, *_ = map(stack.enter_context, crowd(port, scheme="https"))
        assert asks_to_stop(port, "https", **BEARER) == 200
        assert first.recv(1) == b""


def test_a_connection_that_has_shown_the_token_is_kept() -> None:
    with served() as port, ExitStack() as stack:
        address = f"ws://127.0.0.1:{port}/api/events"
        page = stack.enter_context(connect(address, additional_headers=BEARER))
        for connection in crowd(port):
            stack.enter_context(connection)
        page.send("still there")
        assert page.recv(PATIENCE) == "still there"


def test_a_new_connection_takes_the_place_of_one_of_the_address_that_has_most() -> None:
    with served() as port, ExitStack() as stack:
        other = stack.enter_context(connected(port, host="127.0.0.2"))
        first, *_ = map(stack.enter_context, crowd(port))
        assert first.recv(1) == b""
        other.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        assert other.recv(100).startswith(b"HTTP/1.1 200")


@pytest.mark.parametrize("data", [b"", HEAD], ids=["nothing", "head"])
def test_without_the_token_a_connection_has_little_time(
    data: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connections, "IDLE_TIMEOUT", 0.1)
    monkeypatch.setattr(connections, "CLEANUP_INTERVAL", 0.05)
    with served() as port, connected(port, data) as waiting:
        address = f"ws://127.0.0.1:{port}/api/events"
        with connect(address, additional_headers=BEARER) as page:
            assert waiting.recv(1) == b""
            page.send("still there")
            assert page.recv(PATIENCE) == "still there"


def test_a_handshake_has_little_time(tls: ssl.SSLContext, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connections, "IDLE_TIMEOUT", 0.1)
    monkeypatch.setattr(connections, "CLEANUP_INTERVAL", 0.05)
    with served(tls) as port, connected(port) as waiting:
        assert waiting.recv(1) == b""


def test_requests_without_the_token_use_up_nothing_of_those_with_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(access_control, "REQUEST_BURST", 2.0)
    monkeypatch.setattr(access_control, "REQUEST_RATE", 0.0)
    with served() as port, httpx.Client(base_url=f"http://127.0.0.1:{port}") as client:
        assert [client.get("/").status_code for _ in range(3)] == [200, 200, 429]
        assert client.post("/api/login", headers=BEARER).status_code == 200


def test_of_several_parts_of_a_file_all_of_it_is_given() -> None:
    with served() as port, httpx.Client(base_url=f"http://127.0.0.1:{port}") as client:
        one = client.get("/file", headers={"Range": "bytes=1-2"})
        assert (one.status_code, one.content) == (206, Path(__file__).read_bytes()[1:3])
        several = client.get("/file", headers={"Range": "bytes=0-0,2-2,4-4"})
        assert (several.status_code, several.content) == (200, Path(__file__).read_bytes())
