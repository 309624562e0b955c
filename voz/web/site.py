"""Where the page is, who may come, and what it takes for HTTPS."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from ssl import SSLContext
from typing import NamedTuple

from voz.web.addresses import is_local, link, own_names, reached_at
from voz.web.doors import Doors, new_token
from voz.web.server import listening_socket

PORT = 8737
"""Where the page is if no other port is wanted."""


class Site(NamedTuple):
    """Where the page is.

    Attributes:
        at: the socket, which is listened at.
        doors: who may come in.
        link: what to open in a browser; it holds the token.
        tls: keys and certificates, for HTTPS.
        authority: the certificate that a phone has to trust for that, PEM.
    """

    at: socket.socket
    doors: Doors
    link: str
    tls: SSLContext | None = None
    authority: bytes | None = None


@contextmanager
def open_site(host: str, port: int, https: bool = False) -> Iterator[Site]:
    """Take the address of a page for a `with` block.

    Args:
        host: the interface.
        port: of it.
        https: whether what is sent is encrypted.

    Raises:
        ConfigError: the address cannot be had.
    """
    token = None if is_local(host) else new_token()
    names = own_names(host)
    with listening_socket(host, port) as at:
        port = at.getsockname()[1]
        doors = Doors(names, token, f"voz-{port}")
        shown = link(reached_at(host), port, https, token)
        yield Site(at, doors, shown)
