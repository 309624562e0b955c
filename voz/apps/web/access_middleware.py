"""ASGI middleware in front of the application: access control, size and rate limits, headers."""

from __future__ import annotations

import time
from contextlib import nullcontext
from http import HTTPStatus

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from voz.apps.servers.connections import ConnectionGuard, network_of
from voz.apps.servers.rate_limits import REQUEST_BURST, REQUEST_RATE, rate_limit_per_client
from voz.apps.web.access_control import AccessControl

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
