"""Where the page is served, who may open it, its certificates, and the link to it."""

from __future__ import annotations

import asyncio
import io
import ipaddress
import socket
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from ssl import SSLContext

from starlette.types import ASGIApp

from voz.apps.servers.connections import ListeningSocket
from voz.apps.web.access_control import AccessControl, new_token
from voz.apps.web.access_middleware import AccessMiddleware
from voz.apps.web.certificates import Certificates
from voz.apps.web.web_server import open_page_socket, running_server

LOOPBACK_NAMES = ("localhost", "127.0.0.1", "::1")


@dataclass(frozen=True)
class PageAddress:
    """Where the page is served.

    Attributes:
        listener: the socket that is listened on.
        access: who may open the page.
        link: what to open in a browser; it holds the token.
        host: the interface.
        certificates: for HTTPS.
    """

    listener: ListeningSocket
    access: AccessControl
    link: str
    host: str
    certificates: Certificates | None = None

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
