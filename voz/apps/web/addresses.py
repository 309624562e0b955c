"""Under which names and addresses this computer is reached, and the link to its page."""

from __future__ import annotations

import io
import ipaddress
import socket
from collections.abc import Iterable
from contextlib import suppress

LOCAL = ("localhost", "127.0.0.1", "::1")
"""Names of this computer that no other one can use."""


def is_local(host: str) -> bool:
    """Whether a host is this computer as seen from itself alone."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def own_names(host: str) -> list[str]:
    """List the names and addresses by which a page on some interface is asked for.

    Args:
        host: the interface's name or address; `0.0.0.0` and `::` are all.
    """
    name = socket.gethostname().lower()
    names = [*LOCAL, host.lower()]
    if not is_local(host):
        names += [name, f"{name.partition('.')[0]}.local", *_addresses()]
    return list(dict.fromkeys(names))


def reached_at(host: str) -> str:
    """Tell the address to type into another computer."""
    if host not in ("0.0.0.0", "::"):
        return host
    return next(iter(_addresses()), "localhost")


def link(host: str, port: int, secure: bool, token: str | None) -> str:
    """Make the link to the page; what stands behind the # is never sent."""
    shown = f"[{host}]" if ":" in host else host
    scheme = "https" if secure else "http"
    return f"{scheme}://{shown}:{port}/" + (f"#token={token}" if token else "")


def qr_code(text: str) -> str:
    """Draw a QR code for a terminal: the camera of a phone opens the link."""
    import segno

    drawn = io.StringIO()
    segno.make(text, error="l", micro=False).terminal(out=drawn, compact=True, border=2)
    return drawn.getvalue().rstrip("\n")


def _addresses() -> Iterable[str]:
    """The address on the way to others, and those that the name of this computer has."""
    found = []
    for family, far in ((socket.AF_INET, "192.0.2.1"), (socket.AF_INET6, "2001:db8::1")):
        try:
            with socket.socket(family, socket.SOCK_DGRAM) as asked:
                asked.connect((far, 9))  # sends nothing: only the way is looked up
                found.append(str(asked.getsockname()[0]))
        except OSError:
            continue
    with suppress(OSError):
        found += [str(each[4][0]) for each in socket.getaddrinfo(socket.gethostname(), None)]
    return [address for address in dict.fromkeys(found) if not is_local(address)]
