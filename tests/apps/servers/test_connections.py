"""The connections of all servers: bounded, and closed if they are idle, in a time of its own."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.apps.servers.connections import (
    ALL_PLACES,
    IDLE_TIMEOUT,
    PAGE_PLACES,
    ConnectionGuard,
    Peer,
    Places,
    RateLimit,
    fitting,
    network_of,
    rate_limit_per_client,
)


class Server:
    """A guard of few places, and the clients that came to it."""

    def __init__(self, stack: ExitStack) -> None:
        self.now = 0.0
        self.guard = ConnectionGuard(Places(idle=4, answered=2, backlog=1), lambda: self.now)
        self._stack = stack
        self._clients: dict[Peer, socket.socket] = {}
        self._served: dict[Peer, socket.socket] = {}

    def connect(self, host: str) -> Peer:
        """A client comes from an address."""
        ours, theirs = map(self._stack.enter_context, socket.socketpair())
        peer = (host, len(self._clients))
        self._clients[peer], self._served[peer] = theirs, ours
        self.guard.add(ours, peer)
        return peer

    def leave(self, peer: Peer) -> None:
        """A client goes, and its connection is closed."""
        self._clients[peer].close()
        self._served[peer].close()

    def is_closed(self, peer: Peer) -> bool:
        """Whether the server has closed a connection."""
        self._clients[peer].setblocking(False)
        try:
            return self._clients[peer].recv(1) == b""
        except BlockingIOError:
            return False


@pytest.fixture
def server() -> Iterator[Server]:
    with ExitStack() as stack:
        yield Server(stack)


def test_for_each_idle_connection_too_many_the_oldest_of_the_network_with_most_is_closed(
    server: Server,
) -> None:
    alone = server.connect("192.0.2.1")
    many = [server.connect("192.0.2.2") for _ in range(9)]
    assert [server.is_closed(peer) for peer in many] == [True] * 6 + [False] * 3
    assert not server.is_closed(alone)
    late = server.connect("192.0.2.3")
    assert not server.is_closed(late)


def test_who_is_answered_is_kept_and_of_those_only_so_many(server: Server) -> None:
    first = [server.connect("192.0.2.1") for _ in range(3)]
    with ExitStack() as answers:
        for peer in first:
            answers.enter_context(server.guard.answering(peer))
        for _ in range(9):
            server.connect("192.0.2.1")
        assert [server.is_closed(peer) for peer in first] == [False, False, True]
        server.now = 9 * IDLE_TIMEOUT
        server.guard.close_late()
        assert [server.is_closed(peer) for peer in first] == [False, False, True]


def test_a_connection_is_idle_since_its_last_answer(server: Server) -> None:
    talks, silent = server.connect("192.0.2.1"), server.connect("192.0.2.1")
    for _ in range(3):
        server.now += 0.7 * IDLE_TIMEOUT
        server.guard.close_late()
        with server.guard.answering(talks):
            pass
    assert (server.is_closed(talks), server.is_closed(silent)) == (False, True)
    for _ in range(4):  # and so is the order in which they give way
        server.connect("192.0.2.1")
        with server.guard.answering(talks):
            pass
    assert not server.is_closed(talks)


def test_a_connection_that_its_client_has_closed_takes_no_place(server: Server) -> None:
    first = server.connect("192.0.2.1")
    for _ in range(9):
        server.leave(server.connect("192.0.2.1"))
    assert not server.is_closed(first)
    with server.guard.answering(first):
        server.leave(first)
    server.now = 2 * IDLE_TIMEOUT
    server.guard.close_late()


def test_what_closes_a_connection_may_be_more_than_its_socket(server: Server) -> None:
    ended: list[str] = []
    server.guard.close_by(server.connect("192.0.2.1"), lambda: ended.append("handler"))
    for _ in range(4):
        server.connect("192.0.2.1")
    assert ended == ["handler"]


@given(st.integers(32, 100_000))
def test_all_servers_leave_files_to_the_rest_of_voz(file_limit: int) -> None:
    taken = sum(fitting(places, file_limit).total for places in ALL_PLACES)
    assert taken <= file_limit - min(200, file_limit // 2)
    assert all(min(vars(fitting(places, file_limit)).values()) >= 1 for places in ALL_PLACES)


def test_with_the_limit_of_most_systems_no_place_is_missing() -> None:
    assert fitting(PAGE_PLACES, 1024) == PAGE_PLACES


@pytest.mark.parametrize(
    ("host", "network"),
    [
        ("192.0.2.1", "192.0.2.1"),
        ("2001:db8:1:2:3::4", "2001:db8:1:2::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("::ffff:192.0.2.1", "192.0.2.1"),
        ("unix", "unix"),
    ],
)
def test_all_addresses_of_one_owner_are_one(host: str, network: str) -> None:
    assert network_of((host, 1)) == network


@given(st.lists(st.floats(0, 10), max_size=200))
def test_no_more_comes_through_than_is_allowed(pauses: list[float]) -> None:
    limit, now, through = RateLimit(2.0, 5.0), 0.0, 0
    for pause in pauses:
        now += pause
        through += limit.allows(now)
        assert through <= 5 + 2 * now + 1e-6


@given(st.lists(st.tuples(st.sampled_from("abc"), st.floats(0, 10)), max_size=200))
def test_each_one_has_a_limit_of_its_own(asked: list[tuple[str, float]]) -> None:
    limit_of, now = rate_limit_per_client(2.0, 5.0), 0.0
    own = {one: RateLimit(2.0, 5.0) for one in "abc"}
    for one, pause in asked:
        now += pause
        assert limit_of(one).allows(now) == own[one].allows(now)
