"""Home Assistant finds a Wyoming server by zeroconf: a real browser, on the loopback interface."""

from __future__ import annotations

import asyncio
import ipaddress
import queue
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from programs import PATIENCE
from zeroconf import ServiceBrowser, ServiceStateChange, Zeroconf

from voz.apps.wyoming import announcement
from voz.apps.wyoming.announcement import WYOMING_SERVICE, announced, reached_addresses

LOOPBACK = ["127.0.0.1"]

Changes = queue.Queue[tuple[ServiceStateChange, str]]


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "::1", "no-such-host.invalid"])
def test_what_others_do_not_reach_is_not_announced(host: str) -> None:
    assert reached_addresses(host) == []


def test_where_others_reach_it_is_announced() -> None:
    assert reached_addresses("192.0.2.7") == ["192.0.2.7"]
    everywhere = map(ipaddress.ip_address, reached_addresses("0.0.0.0"))
    assert all(each.version == 4 and not each.is_loopback for each in everywhere)


@contextmanager
def browsed() -> Iterator[tuple[Zeroconf, Changes]]:
    """A browser as Home Assistant's, and what it finds and loses."""
    changes: Changes = queue.Queue()

    def note(name: str, state_change: ServiceStateChange, **_: object) -> None:
        changes.put((state_change, name))

    browsing = Zeroconf(interfaces=LOOPBACK)
    browser = ServiceBrowser(browsing, WYOMING_SERVICE, handlers=[note])
    try:
        yield browsing, changes
    finally:
        browser.cancel()
        browsing.close()


def test_a_browser_finds_it_once_there_is_a_network_and_sees_it_go(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(announcement, "ADDRESS_INTERVAL", 0.1)
    lookups = iter([[], [], LOOPBACK])
    warnings: list[str] = []

    async def serve(browsing: Zeroconf, changes: Changes) -> str:
        lookup = lambda _: next(lookups, LOOPBACK)  # noqa: E731
        async with announced("tcp://0.0.0.0:10499", warnings.append, lookup):
            change, name = await asyncio.to_thread(changes.get, True, PATIENCE)
            assert change is ServiceStateChange.Added
            found = await asyncio.to_thread(browsing.get_service_info, WYOMING_SERVICE, name)
            assert found
            assert (found.port, found.parsed_addresses()) == (10499, LOOPBACK)
        return name

    with browsed() as (browsing, changes):
        name = asyncio.run(serve(browsing, changes))
        assert name.startswith("voz-10499-")
        assert changes.get(timeout=PATIENCE) == (ServiceStateChange.Removed, name)
    assert warnings == []


# The library leaves a socket open.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_network_that_cannot_is_one_warning_and_it_serves_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(announcement, "ADDRESS_INTERVAL", 0.01)
    tried: list[str] = []
    warnings: list[str] = []

    def lookup(host: str) -> list[str]:
        tried.append(host)
        return ["192.0.2.7"]  # this computer has no such address

    async def serve() -> None:
        async with announced("tcp://0.0.0.0:10499", warnings.append, lookup):
            while len(tried) < 3:
                await asyncio.sleep(0.01)

    asyncio.run(serve())
    (warning,) = warnings
    assert "cannot be announced" in warning


@pytest.mark.parametrize("uri", ["unix:///tmp/voz", "nonsense"])
def test_what_has_no_port_is_not_announced(uri: str) -> None:
    async def serve() -> None:
        async with announced(uri, pytest.fail):
            pass

    asyncio.run(serve())
