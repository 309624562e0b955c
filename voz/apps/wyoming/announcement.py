"""Announces a Wyoming server in the network by zeroconf (mDNS), so that Home Assistant finds it.

Home Assistant browses `_wyoming._tcp.local.`, asks what it found to describe itself, and remembers
it by the name of the service: so that is the same after each start.
"""

from __future__ import annotations

import asyncio
import ipaddress
import socket
import uuid
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

if TYPE_CHECKING:
    from zeroconf.asyncio import AsyncZeroconf

WYOMING_SERVICE = "_wyoming._tcp.local."

ADDRESS_INTERVAL = 5.0
"""The addresses are looked up so often, s: a robot may start before its wireless network does."""

Address = ipaddress.IPv4Address | ipaddress.IPv6Address

Lookup = Callable[[str], Sequence[str]]
"""Returns the addresses at which others reach a server that listens at a host."""


def reached_addresses(host: str) -> list[str]:
    """The addresses at which others reach a server at a host; none if only this computer does."""
    return [
        str(address)
        for address in _listened(host)
        if not (address.is_loopback or (address.version == 6 and address.is_link_local))
    ]


@asynccontextmanager
async def announced(
    uri: str, warn: Callable[[str], None], lookup: Lookup = reached_addresses
) -> AsyncIterator[None]:
    """Announce a server that listens at an address for a `with` block, wherever others reach it.

    `warn` is called once if it cannot be announced; that is tried again.
    """
    link = urlsplit(uri)
    if link.scheme != "tcp" or not link.hostname or not link.port:
        yield
        return
    task = asyncio.create_task(_keep_announced(link.hostname, link.port, warn, lookup))
    try:
        yield
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


async def _keep_announced(
    host: str, port: int, warn: Callable[[str], None], lookup: Lookup
) -> None:
    """Announce a server until cancelled, anew when the computer's addresses change."""
    from zeroconf import Error

    opened: AsyncZeroconf | None = None
    known: Sequence[str] = []
    warned = False
    try:
        while True:
            found = await asyncio.to_thread(lookup, host)
            if found != known:
                opened, closed = None, opened
                await _close(closed)
                try:
                    opened, known = await _open(port, found), found
                except (OSError, Error) as error:
                    known = []
                    if not warned:
                        warn(f"the Wyoming server cannot be announced in the network ({error})")
                    warned = True
            await asyncio.sleep(ADDRESS_INTERVAL)
    finally:
        await _close(opened)


async def _open(port: int, addresses: Sequence[str]) -> AsyncZeroconf | None:
    """Announce a server at addresses; None if there are none."""
    if not addresses:
        return None
    from zeroconf.asyncio import AsyncServiceInfo, AsyncZeroconf

    card = f"{uuid.getnode():012x}"  # its address, by which wyoming's own servers are named, too
    service = AsyncServiceInfo(
        WYOMING_SERVICE,
        f"voz-{port}-{card}.{WYOMING_SERVICE}",
        port=port,
        parsed_addresses=list(addresses),
        server=f"voz-{card}.local.",
    )
    opened = AsyncZeroconf(interfaces=list(addresses))
    try:
        await (await opened.async_register_service(service, allow_name_change=True))
    except BaseException:
        await opened.async_close()
        raise
    return opened


async def _close(opened: AsyncZeroconf | None) -> None:
    """Withdraw what was announced."""
    if opened:
        with suppress(OSError):
            await opened.async_unregister_all_services()
        await opened.async_close()


def _listened(host: str) -> list[Address]:
    """The addresses that a server at a host listens on."""
    with suppress(ValueError):
        address = ipaddress.ip_address(host)
        return _own_addresses(address.version) if address.is_unspecified else [address]
    try:
        found = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)
    except OSError:
        return []
    return [ipaddress.ip_address(str(each[4][0])) for each in found]


def _own_addresses(version: int) -> list[Address]:
    """All addresses of this computer."""
    import ifaddr  # which zeroconf needs, too

    found = [ip for adapter in ifaddr.get_adapters() for ip in adapter.ips]
    return [
        ipaddress.ip_address(ip.ip if isinstance(ip.ip, str) else ip.ip[0])
        for ip in found
        if ip.is_IPv4 == (version == 4)
    ]
