"""Where the page is served, who may open it, and its certificates."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from ssl import SSLContext

from starlette.types import ASGIApp

from voz.apps.web.access_control import AccessControl, new_token
from voz.apps.web.access_middleware import AccessMiddleware
from voz.apps.web.certificates import Certificates
from voz.apps.web.host_addresses import is_local_host, own_host_names, page_link, reachable_host
from voz.apps.web.listening_socket import ListeningSocket
from voz.apps.web.web_server import open_listening_socket, running_server


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
        guarded = AccessMiddleware(app, self.access, self.listener)
        return running_server(guarded, self.listener, self.tls, start_tasks, warn)

    def renew_certificate(self) -> None:
        """Renew the certificate if it ends soon, or this computer has another address."""
        if self.certificates:
            self.certificates.renew(own_host_names(self.host), datetime.now(timezone.utc))


@contextmanager
def open_page_address(host: str, port: int, authority: Path | None) -> Iterator[PageAddress]:
    """Listen on the address of a page for a `with` block.

    Args:
        host: the interface.
        port: of it.
        authority: the folder of the certificate authority, for HTTPS; None for HTTP.

    Raises:
        ConfigError: the address cannot be bound, or the folder cannot be used.
    """
    token = None if is_local_host(host) else new_token()
    names = own_host_names(host)
    with open_listening_socket(host, port) as listener:
        port = listener.getsockname()[1]
        access = AccessControl(names, token, f"voz-{port}")
        link = page_link(reachable_host(host), port, authority is not None, token)
        certificates = Certificates(authority) if authority else None
        address = PageAddress(listener, access, link, host, certificates)
        address.renew_certificate()
        yield address
