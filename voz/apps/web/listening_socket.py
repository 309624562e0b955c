"""The socket that the server listens on: clients without the token keep nobody else out.

Who has the token cannot be known before a request has come, and behind a tunnel or a proxy all come
from one address. So every connection is accepted, and has a short time to show the token; if too
many wait, one of the address that has most of them is closed for each new one. None is closed
whose request is being answered and has shown the token.
"""

from __future__ import annotations

import asyncio
import gc
import socket
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

MAX_UNAUTHENTICATED = 200
"""Connections that have not shown the token: 25 pages open at a time with these."""

MAX_AUTHENTICATED = 300
"""Connections that have, and are kept: 100 pages, their microphones, and as many programs.

With those that wait they are less than the 1,024 files that most systems let a program open.
"""

AUTHENTICATION_TIMEOUT = 20.0
"""For the TLS handshake, the request and, without the token, its answer, s."""

ACCEPT_BACKLOG = 64
"""Connections that the system queues, and that are accepted at once.

A longer queue lets a flood through: at 1,000 connections/s a client with the token then comes too
late in half of the cases, and in none with this, as whoever finds it full has to try again.
"""

CLEANUP_INTERVAL = 0.5
"""How often connections that took too long are closed, s."""

Peer = tuple[str, int]
"""The address and the port that a connection comes from."""


@dataclass(frozen=True, slots=True)
class _Waiting:
    connection: socket.socket
    since: float


class ListeningSocket(socket.socket):
    """A listening socket with a bounded number of connections. Event-loop thread only."""

    def __init__(self, *arguments: Any) -> None:
        """Make the socket, with the arguments of `socket.socket`."""
        super().__init__(*arguments)
        self._waiting: dict[Peer, _Waiting] = {}  # the oldest first
        self._authenticated: set[Peer] = set()
        self._accepted = 0  # since the last garbage collection

    def accept(self) -> tuple[socket.socket, Any]:
        """Accept a connection; if too many wait, another one is closed for it."""
        connection, address = super().accept()
        if len(self._waiting) >= MAX_UNAUTHENTICATED:
            self._forget_closed()
        if len(self._waiting) >= MAX_UNAUTHENTICATED:
            self._close(self._one_too_many())
        self._waiting[address[:2]] = _Waiting(connection, time.monotonic())
        self._accepted += 1
        return connection, address

    @contextmanager
    def answering(self, peer: Peer | None) -> Iterator[None]:
        """Keep the connection of a peer for a `with` block: its request has shown the token."""
        kept = None
        if peer and len(self._authenticated) < MAX_AUTHENTICATED:
            kept = self._waiting.pop(peer, None)
        if not peer or not kept:
            yield
            return
        self._authenticated.add(peer)
        try:
            yield
        finally:
            self._authenticated.discard(peer)
            if kept.connection.fileno() >= 0:  # else another may come from there by now
                self._waiting[peer] = _Waiting(kept.connection, time.monotonic())

    async def close_late(self) -> None:
        """Close connections that took too long, again and again, without end."""
        while True:
            self._forget_closed()
            late = time.monotonic() - AUTHENTICATION_TIMEOUT
            for peer in [peer for peer, waiting in self._waiting.items() if waiting.since < late]:
                self._close(peer)
            if self._accepted > MAX_UNAUTHENTICATED:
                # Pythons of before 2024 leave a failed TLS handshake, 0.3 MB, in a reference cycle.
                gc.collect()
                self._accepted = 0
            await asyncio.sleep(CLEANUP_INTERVAL)

    def _one_too_many(self) -> Peer:
        """The oldest that waits of the address that has most of them."""
        most, _ = Counter(host for host, _ in self._waiting).most_common(1)[0]
        return next(peer for peer in self._waiting if peer[0] == most)

    def _close(self, peer: Peer) -> None:
        """End a connection: asyncio, which owns it, finds that and closes it."""
        with suppress(OSError):  # it has gone already
            self._waiting.pop(peer).connection.shutdown(socket.SHUT_RDWR)

    def _forget_closed(self) -> None:
        closed = [p for p, waiting in self._waiting.items() if waiting.connection.fileno() < 0]
        for peer in closed:
            del self._waiting[peer]
