"""Who may send requests: checks of Host, Origin, token, size and rate.

The token is never part of an address that is sent: it stands behind the # of the link, and the page
exchanges it for a cookie. So no log and no Referer has it.
"""

from __future__ import annotations

import hmac
import secrets
import time
from collections import deque
from collections.abc import Collection
from contextlib import nullcontext, suppress
from http import HTTPStatus
from ipaddress import ip_address
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from voz.apps.servers.connections import (
    REQUEST_BURST,
    REQUEST_RATE,
    ConnectionGuard,
    network_of,
    rate_limit_per_client,
)

MAX_SESSIONS = 200
"""Browsers that are logged in at a time; with more, the first has to show the token again."""

TOKEN_BYTES = 24


def new_token() -> str:
    """Make a token that nobody can guess."""
    return secrets.token_urlsafe(TOKEN_BYTES)


class AccessControl:
    """Decides about requests by their headers."""

    def __init__(self, hosts: Collection[str], token: str | None = None, cookie: str = "voz"):
        """Set who may send requests.

        Args:
            hosts: the names of this server, in lower case; under another name a stranger's page
                would count as this one (DNS rebinding).
            token: what a client must know; None lets every client in.
            cookie: the name of the cookie of clients that have shown the token.
        """
        self.cookie = cookie
        self._hosts = frozenset(hosts)
        self._token = token
        self._sessions: deque[str] = deque(maxlen=MAX_SESSIONS)

    @property
    def needs_token(self) -> bool:
        """Whether a client must show a token."""
        return self._token is not None

    def refusal(self, headers: Headers) -> str | None:
        """Return why a request is refused for its Host or Origin; None if it is not."""
        hosts = headers.getlist("host")
        host = hosts[0].lower() if len(hosts) == 1 else ""
        if not self._is_own(_without_port(host)):
            return "this server has another name: use the address that `voz run` shows"
        own = (f"http://{host}", f"https://{host}")
        if "cross-site" in headers.getlist("sec-fetch-site") or any(
            origin.lower() not in own for origin in headers.getlist("origin")
        ):
            return "another site's page may not drive this robot"
        return None

    def _is_own(self, name: str) -> bool:
        with suppress(ValueError):
            return bool(ip_address(name))  # DNS rebinding needs a name
        return name in self._hosts

    def is_authenticated(self, headers: Headers) -> bool:
        """Whether the client has shown the token, in this request or before."""
        if self._token is None:
            return True
        bearer = headers.get("authorization", "").removeprefix("Bearer ")
        if secrets_equal(bearer, self._token):
            return True
        cookies = (part.strip().partition("=") for part in headers.get("cookie", "").split(";"))
        # The first alone: a stranger could send thousands, each compared with all sessions.
        shown = next((value for name, _, value in cookies if name == self.cookie), "")
        return any(secrets_equal(shown, session) for session in self._sessions)

    def log_in(self, token: str) -> str | None:
        """Begin a session; returns the value of its cookie, None if the token is wrong."""
        if self._token is not None and not secrets_equal(token, self._token):
            return None
        self._sessions.append(session := new_token())
        return session


def _without_port(host: str) -> str:
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def secrets_equal(shown: str, known: str) -> bool:
    """Compare two secrets in a time that does not depend on where they differ."""
    return hmac.compare_digest(shown.encode("utf-8", "replace"), known.encode())


MAX_BODY_BYTES = 4096
"""Of a request; a command has at most 200 letters."""

STOP_PATH = "/api/stop"

PUBLIC_PATHS = ("/api/login", "/api/authority.crt")
"""Paths under /api that need no token."""

CONTENT_SECURITY_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "media-src 'self'; manifest-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'"
)

SECURITY_HEADERS = {
    "Content-Security-Policy": CONTENT_SECURITY_POLICY,
    "Permissions-Policy": "microphone=(self), camera=(), geolocation=()",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class AccessMiddleware:
    """Refuses requests that may not be served, and passes on the others."""

    def __init__(self, app: ASGIApp, access: AccessControl, guard: ConnectionGuard) -> None:
        self._app = app
        self._access = access
        self._guard = guard
        self._limit_of = rate_limit_per_client(REQUEST_RATE, REQUEST_BURST)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request or a WebSocket."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        authenticated = self._access.is_authenticated(headers)
        status, why = self._refusal(scope, headers, authenticated)
        if why is None:
            scope["headers"] = [
                header for header in scope["headers"] if not _is_multi_range(header)
            ]
            with self._guard.answering(scope["client"]) if authenticated else nullcontext():
                await self._app(scope, receive, _with_security_headers(send))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": why})
        else:
            await JSONResponse({"error": why}, status)(scope, receive, _with_security_headers(send))

    def _refusal(
        self, scope: Scope, headers: Headers, authenticated: bool
    ) -> tuple[HTTPStatus, str | None]:
        path = scope["path"]
        if why := self._access.refusal(headers):
            return HTTPStatus.FORBIDDEN, why
        # Requests with the token count apart: behind a proxy all have one address.
        client = (scope["client"] and network_of(scope["client"]), authenticated)
        if path != STOP_PATH and not self._limit_of(client).allows(time.monotonic()):
            return HTTPStatus.TOO_MANY_REQUESTS, "too many requests"
        if path.startswith("/api/") and path not in PUBLIC_PATHS and not authenticated:
            return HTTPStatus.UNAUTHORIZED, "open the link that `voz run` shows: it has the token"
        length = headers.get("content-length", "0")
        if not length.isdecimal() or int(length[:9]) > MAX_BODY_BYTES:
            return HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "request body too large"
        return HTTPStatus.OK, None


def _is_multi_range(header: tuple[bytes, bytes]) -> bool:
    """Whether it asks for several ranges of a file, which no browser does: they cost much time."""
    name, value = header
    return name == b"range" and b"," in value


def _with_security_headers(send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message).update(SECURITY_HEADERS)
        await send(message)

    return send_with_headers
