"""The names and addresses of this computer, and the link to its page."""

from __future__ import annotations

import io
import ipaddress
import socket
from collections.abc import Iterable
from contextlib import suppress

LOOPBACK_NAMES = ("localhost", "127.0.0.1", "::1")


def is_local_host(host: str) -> bool:
    """Whether only this computer itself can reach a host."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def own_host_names(host: str) -> list[str]:
    """List the names and addresses under which a page may be asked for.

    Args:
        host: the interface's name or address; `0.0.0.0` and `::` are all.
    """
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
