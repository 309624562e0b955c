"""What both Wyoming servers share: a client that is idle, slow or wrong keeps nobody out."""

from __future__ import annotations

import asyncio
import json
import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest
from programs import PATIENCE, free_port, wait_until
from wyoming.client import AsyncClient
from wyoming.event import Event
from wyoming.ping import Ping, Pong

from voz.apps.servers import connections
from voz.apps.servers.connections import Places
from voz.apps.wyoming import connection
from voz.apps.wyoming.connection import Connection, serving
from voz.errors import ConfigError

PLACES = Places(idle=4, answered=2, backlog=64)

DEEP = b"[" * 60_000 + b"\n"

PING = json.dumps({"type": "ping"}).encode() + b"\n"


class Echo(Connection):
    """Answers a ping; of a long one only the end comes, as of a client's sound."""

    max_bytes = 1000

    async def answer(self, event: Event) -> None:
        if event.payload:
            await asyncio.Event().wait()
        await self.write_event(Pong(text=str(event.data)).event())


@pytest.fixture(params=["tcp", "unix"])
def uri(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param == "tcp":
        return f"tcp://127.0.0.1:{free_port()}"
    return f"unix://{tmp_path / 'voz.socket'}"


@contextmanager
def served(uri: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[object]]:
    """A server with few places for a `with` block; yields what its event loop complains of."""
    monkeypatch.setattr(connection, "WYOMING_PLACES", PLACES)
    complaints: list[object] = []
    started, loops = threading.Event(), []

    async def work() -> None:
        loop, ended = asyncio.get_running_loop(), asyncio.Event()
        loop.set_exception_handler(lambda _, context: complaints.append(context))
        async with serving(uri, Echo):
            loops.append((loop, ended))
            started.set()
            await ended.wait()

    thread = threading.Thread(target=lambda: asyncio.run(work()))
    thread.start()
    assert started.wait(PATIENCE)
    ((loop, ended),) = loops
    try:
        yield complaints
    finally:
        loop.call_soon_threadsafe(ended.set)
        thread.join()


def opened(uri: str, data: bytes = b"") -> socket.socket:
    """A connection over which something was sent."""
    if uri.startswith("unix://"):
        client = socket.socket(socket.AF_UNIX)
        address: object = uri.removeprefix("unix://")
    else:
        client, address = socket.socket(), ("127.0.0.1", int(uri.rpartition(":")[2]))
    client.settimeout(PATIENCE)
    client.connect(address)
    client.sendall(data)
    return client


def is_closed(client: socket.socket) -> bool:
    """Whether the server has closed a connection."""
    client.setblocking(False)
    try:
        return client.recv(1) == b""
    except BlockingIOError:
        return False
    except ConnectionError:
        return True


def answers(uri: str) -> bool:
    async def ask() -> Event | None:
        async with AsyncClient.from_uri(uri) as client:
            await client.write_event(Ping().event())
            return await asyncio.wait_for(client.read_event(), PATIENCE)

    answer = asyncio.run(ask())
    return answer is not None and Pong.is_type(answer.type)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b'{"type": "pi',
        b'{"type": "ping", "data_length": 500}\n{',
        b'{"type": "ping", "payload_length": 3}\nabc',
    ],
    ids=["nothing", "half an event", "half of its data", "what is answered for ever"],
)
def test_however_many_connections_are_idle_or_busy_a_new_one_is_answered(
    data: bytes, uri: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with served(uri, monkeypatch) as complaints, ExitStack() as stack:
        clients = [stack.enter_context(opened(uri, data)) for _ in range(60)]
        assert answers(uri)
        kept = PLACES.idle + PLACES.answered
        wait_until(lambda: sum(map(is_closed, clients)) >= len(clients) - kept)
        assert answers(uri)
    assert complaints == []


def test_single_bytes_keep_no_connection_open(uri: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connections, "IDLE_TIMEOUT", 0.2)
    monkeypatch.setattr(connections, "CLEANUP_INTERVAL", 0.02)
    with served(uri, monkeypatch), opened(uri, b'{"type": "') as slow:
        slow.settimeout(0.02)
        while True:
            try:
                slow.sendall(b"a")
                assert slow.recv(1) == b""
            except TimeoutError:
                continue
            except ConnectionError:
                pass
            break
        assert answers(uri)


def test_who_takes_no_answer_is_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    uri = f"unix://{tmp_path / 'voz.socket'}"
    monkeypatch.setattr(connection, "IDLE_TIMEOUT", 0.2)
    with served(uri, monkeypatch) as complaints, opened(uri) as deaf:
        with suppress(ConnectionError):
            while True:  # until no more answers can be written, and so no more events are read
                deaf.sendall(PING * 1000)
        assert answers(uri)
    assert complaints == []


@pytest.mark.parametrize("garbage", [DEEP, b"\xff\n", b"null\n", b'{"data_length": "x"}\n'])
def test_garbage_ends_its_connection_without_a_word(
    garbage: bytes, uri: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with served(uri, monkeypatch) as complaints:
        with opened(uri, garbage) as client:
            client.shutdown(socket.SHUT_WR)
            assert client.recv(1) == b""
        assert answers(uri)
    assert complaints == []


def test_a_file_that_is_no_socket_is_not_touched(tmp_path: Path) -> None:
    async def serve(uri: str) -> None:
        async with serving(uri, Echo):
            pass

    (kept := tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(ConfigError, match="cannot listen there"):
        asyncio.run(serve(f"unix://{kept}"))
    assert kept.read_text() == "mine"
    left = tmp_path / "left.socket"
    for _ in range(2):  # the second finds what a run left that was killed
        with socket.socket(socket.AF_UNIX) as old:
            if not left.exists():
                old.bind(str(left))
        asyncio.run(serve(f"unix://{left}"))
    assert not left.exists()
