"""Where the page is, who may come, and what it takes for HTTPS."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime, timezone
from pathlib import Path
from ssl import SSLContext
from typing import NamedTuple

from voz.apps.web.addresses import is_local, link, own_names, reached_at
from voz.apps.web.certificates import Certificates
from voz.apps.web.doors import Doors, new_token
from voz.apps.web.listener import ListeningSocket
from voz.apps.web.server import listening_socket

PORT = 8737
"""Where the page is if no other port is wanted."""


class Site(NamedTuple):
    """Where the page is.

    Attributes:
        at: the socket, which is listened at.
        doors: who may come in.
        link: what to open in a browser; it holds the token.
        host: the interface.
        certificates: for HTTPS.
    """

    at: ListeningSocket
    doors: Doors
    link: str
    host: str
    certificates: Certificates | None = None

    @property
    def tls(self) -> SSLContext | None:
        """Serves HTTPS by the newest certificate; None for HTTP."""
        return self.certificates.context if self.certificates else None

    @property
    def authority(self) -> bytes | None:
        """The certificate that a phone has to trust, PEM; None for HTTP."""
        return self.certificates.authority if self.certificates else None

    def renew(self) -> None:
        """Make the certificate anew, if it is time or this computer has another address."""
        if self.certificates:
            self.certificates.renew(own_names(self.host), datetime.now(timezone.utc))


@contextmanager
def open_site(host: str, port: int, authority: Path | None) -> Iterator[Site]:
    """Take the address of a page for a `with` block.

    Args:
        host: the interface.
        port: of it.
        authority: the folder of what vouches for it, for HTTPS; None for HTTP.

    Raises:
        ConfigError: the address cannot be had, or the folder not be used.
    """
    token = None if is_local(host) else new_token()
    names = own_names(host)
    with listening_socket(host, port) as at:
        port = at.getsockname()[1]
        doors = Doors(names, token, f"voz-{port}")
        shown = link(reached_at(host), port, authority is not None, token)
        site = Site(at, doors, shown, host, Certificates(authority) if authority else None)
        site.renew()
        yield site
