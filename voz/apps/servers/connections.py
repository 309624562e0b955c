"""The connections of voz's servers, and their rates: clients that do nothing keep nobody out.

Who may come in cannot be known before a client has sent something, and behind a tunnel or a proxy
all come from one address. So every connection is accepted, and is idle until its client has sent
what the server answers; if too many are idle, one of the address that has most of them is closed
for each new one. None is closed that is being answered.

Each server has places of its own, so that none can take those of another, as the one for the page's
stop. All places of a process are fewer than the files that it may open.
"""

from __future__ import annotations

import asyncio
import gc
import resource
import socket
import time
from collections import Counter
from collections.abc import Callable, Hashable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import astuple, dataclass
from functools import lru_cache, partial
from ipaddress import ip_address, ip_network
from itertools import count
from typing import Any

IDLE_TIMEOUT = 20.0
"""For a TLS handshake and a whole request or event, s: single bytes of one do not count."""

SERVER_SHUTDOWN_TIMEOUT = 2.0
"""For a server to end, s; the robot is at rest by then."""

CLEANUP_INTERVAL = 0.5
"""How often connections that were idle for too long are closed, s."""

RESERVED_FILES = 200
"""Open files that no server takes: robots, sound, programs, recordings. Half of them, if fewer."""

MANY_ACCEPTED = 200

UNIX = "unix"
"""The address of all clients of a socket that is a file."""

Peer = tuple[str, int]
"""The address and the port that a connection comes from."""


@dataclass(frozen=True)
class Places:
    """How many connections a server may have."""

    idle: int  # those whose clients have sent nothing yet that is answered
    answered: int  # those that are being answered, and are kept meanwhile; more are answered unkept
    # Those that the system queues, and that are accepted at once. A longer queue lets a flood
    # through: at 1,000 connections/s of others a client comes too late in half of the cases with
    # 100, and in none with 64, as whoever finds it full has to try again.
    backlog: int

    @property
    def total(self) -> int:
        """How many files they are at most."""
        return self.idle + self.answered + self.backlog


PAGE_PLACES = Places(idle=200, answered=300, backlog=64)
"""25 pages open at a time with so many idle ones; 100 pages, their microphones and as many programs
are answered all the time."""

WYOMING_PLACES = Places(idle=100, answered=50, backlog=50)

ALL_PLACES = (PAGE_PLACES, WYOMING_PLACES)
"""Of the servers that one process may have."""


def fitting(places: Places, file_limit: int) -> Places:
    """Return as many places as all servers together may have where few files may be open."""
    free = file_limit - min(RESERVED_FILES, file_limit // 2)
    share = min(1.0, free / sum(each.total for each in ALL_PLACES))
    return Places(*(max(1, int(number * share)) for number in astuple(places)))


@dataclass(slots=True)
class _Connection:
    """A connection, the network it comes from, since when it is idle, s, and what closes it."""

    socket: socket.socket
    network: str
    since: float
    close: Callable[[], None]


class ConnectionGuard:
    """The connections of one server. Event-loop thread only."""

    def __init__(self, places: Places, now: Callable[[], float] = time.monotonic) -> None:
        """Begin with none; where few files may be open there are fewer places. `now` returns s."""
        soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        unlimited = soft == resource.RLIM_INFINITY
        self.places = places if unlimited else fitting(places, soft)  # how many there may be
        self._now = now
        self._idle: dict[Peer, _Connection] = {}  # the one that is idle for longest first
        self._answered: dict[Peer, _Connection] = {}
        self._accepted = 0  # since the last garbage collection

    def add(self, connection: socket.socket, peer: Peer) -> None:
        """Take a new connection; if too many are idle, another one is closed for it."""
        if len(self._idle) >= self.places.idle:
            self._forget_closed()
        if len(self._idle) >= self.places.idle:
            self._close(self._one_too_many())
        self._idle.pop(peer, None)  # an old one that was closed
        close = partial(connection.shutdown, socket.SHUT_RDWR)  # asyncio finds that and closes it
        self._idle[peer] = _Connection(connection, network_of(peer), self._now(), close)
        self._accepted += 1

    def close_by(self, peer: Peer, close: Callable[[], None]) -> None:
        """Let a connection be closed by a function, which ends what its server does for it."""
        if connection := self._idle.get(peer):
            connection.close = close

    @contextmanager
    def answering(self, peer: Peer | None) -> Iterator[None]:
        """Keep the connection of a peer for a `with` block: it is being answered."""
        kept = None
        if peer and len(self._answered) < self.places.answered:
            kept = self._idle.pop(peer, None)
        if peer and kept:
            self._answered[peer] = kept
        try:
            yield
        finally:
            if peer and kept:
                del self._answered[peer]
                if kept.socket.fileno() >= 0:  # else another may come from there by now
                    self._idle[peer] = kept
            if peer and (connection := self._idle.pop(peer, None)):
                connection.since = self._now()
                self._idle[peer] = connection

    async def close_idle(self) -> None:
        """Close connections that were idle for too long, again and again, without end."""
        while True:
            self.close_late()
            if self._accepted > MANY_ACCEPTED:
                # Pythons of before 2024 leave a failed TLS handshake, 0.3 MB, in a reference cycle.
                gc.collect()
                self._accepted = 0
            await asyncio.sleep(CLEANUP_INTERVAL)

    def close_late(self) -> None:
        """Close the connections that were idle for too long by now."""
        self._forget_closed()
        late = self._now() - IDLE_TIMEOUT
        for peer in [peer for peer, each in self._idle.items() if each.since < late]:
            self._close(peer)

    def _one_too_many(self) -> Peer:
        """The one that is idle for longest of the network that has most of them."""
        most, _ = Counter(each.network for each in self._idle.values()).most_common(1)[0]
        return next(peer for peer, each in self._idle.items() if each.network == most)

    def _close(self, peer: Peer) -> None:
        with suppress(OSError):  # it has gone already
            self._idle.pop(peer).close()

    def _forget_closed(self) -> None:
        for peer in [peer for peer, each in self._idle.items() if each.socket.fileno() < 0]:
            del self._idle[peer]


def network_of(peer: Peer) -> str:
    """The address of a peer; of IPv6 the first half, for its owner has all addresses of that."""
    host = peer[0].partition("%")[0]
    if ":" not in host:
        return host
    address = ip_address(host)
    mapped = getattr(address, "ipv4_mapped", None)
    return str(mapped or ip_network((address, 64), strict=False))


class ListeningSocket(socket.socket):
    """A listening socket whose connections a guard bounds. Event-loop thread only."""

    def __init__(self, guard: ConnectionGuard, *arguments: Any) -> None:
        """Make the socket, with the arguments of `socket.socket`."""
        super().__init__(*arguments)
        self.guard = guard  # may be that of several sockets
        self._numbers = count(1)

    def accept(self) -> tuple[socket.socket, Any]:
        """Accept a connection; of a socket that is a file it gets an address of its own."""
        connection, address = super().accept()
        if self.family not in (socket.AF_INET, socket.AF_INET6):
            address = (UNIX, next(self._numbers))
        self.guard.add(connection, address[:2])
        return connection, address


def open_listening_socket(
    guard: ConnectionGuard, family: int, protocol: int, address: Any
) -> ListeningSocket:
    """Listen at an address of `socket.getaddrinfo`, or a file; raises OSError."""
    with ExitStack() as failing:
        listener = failing.enter_context(
            ListeningSocket(guard, family, socket.SOCK_STREAM, protocol)
        )
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(address)
        listener.listen(guard.places.backlog)
        failing.pop_all()
    return listener


REQUEST_RATE, REQUEST_BURST = 100.0, 400.0
"""Requests or events per second, and at once, from one network; fifty pages open with 400.

Stops are not limited.
"""

MAX_CLIENTS = 1000
"""Clients that are counted; for one more, the one that was silent for longest is forgotten."""


class RateLimit:
    """Allows so many per second, and a burst of so many at once."""

    def __init__(self, rate: float, burst: float) -> None:
        self._rate = rate
        self._burst = self._left = burst
        self._last = 0.0

    def allows(self, now: float, amount: float = 1.0) -> bool:
        """Return whether so much more may come at a time, s, and count it if so."""
        self._left = min(self._burst, self._left + (now - self._last) * self._rate)
        self._last = now
        if amount > self._left:
            return False
        self._left -= amount
        return True


def rate_limit_per_client(rate: float, burst: float) -> Callable[[Hashable], RateLimit]:
    """Return a function from a client to the limit of its own."""
    return lru_cache(MAX_CLIENTS)(lambda _client: RateLimit(rate, burst))
