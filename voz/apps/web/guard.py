"""Stands before the application: refuses strangers, bounds what comes in, limits the page."""

from __future__ import annotations

import time
from contextlib import nullcontext
from http import HTTPStatus

from starlette.datastructures import MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from voz.apps.web.doors import Doors
from voz.apps.web.limits import LimitOfEach
from voz.apps.web.listener import ListeningSocket

MOST_BYTES = 4096
"""Of a request's body; a command has at most 200 letters."""

EACH_SECOND, AT_ONCE = 100.0, 400.0
"""Requests from one address, but for those that stop the robot; fifty pages open with 400.

Those with the token are counted apart, as behind a proxy all come from one address.
"""

STOP_PATH = "/api/stop"

OPEN = ("/api/login", "/api/authority.crt")
"""What is under /api and needs no token."""

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "media-src 'self'; manifest-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'"
)

HEADERS = {
    "Content-Security-Policy": POLICY,
    "Permissions-Policy": "microphone=(self), camera=(), geolocation=()",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class Guard:
    """An application that asks the doors before it lets another one answer."""

    def __init__(self, inside: ASGIApp, doors: Doors, listener: ListeningSocket) -> None:
        self._inside = inside
        self._doors = doors
        self._listener = listener
        self._limits = LimitOfEach(EACH_SECOND, AT_ONCE)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request or a WebSocket."""
        if scope["type"] == "lifespan":
            await self._inside(scope, receive, send)
            return
        known = self._doors.knows(scope["headers"])
        status, why = self._refusal(scope, known)
        if why is None:
            scope["headers"] = [
                header for header in scope["headers"] if not _asks_for_parts(header)
            ]
            with self._listener.answering(scope["client"]) if known else nullcontext():
                await self._inside(scope, receive, _with_headers(send))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": why})
        else:
            await JSONResponse({"error": why}, status)(scope, receive, _with_headers(send))

    def _refusal(self, scope: Scope, known: bool) -> tuple[HTTPStatus, str | None]:
        headers, path = scope["headers"], scope["path"]
        if why := self._doors.refusal(headers):
            return HTTPStatus.FORBIDDEN, why
        address = scope["client"] and scope["client"][0]
        if path != STOP_PATH and not self._limits.allows((address, known), time.monotonic()):
            return HTTPStatus.TOO_MANY_REQUESTS, "too many requests at a time"
        if path.startswith("/api/") and path not in OPEN and not known:
            return HTTPStatus.UNAUTHORIZED, "open the link that `voz run` shows: it has the token"
        length = next((value for name, value in headers if name == b"content-length"), b"0")
        if not length.isdigit() or int(length[:9]) > MOST_BYTES:
            return HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "that is too much for a command"
        return HTTPStatus.OK, None


def _asks_for_parts(header: tuple[bytes, bytes]) -> bool:
    """Whether it asks for several parts of a file, which no browser does: they cost much time."""
    name, value = header
    return name == b"range" and b"," in value


def _with_headers(send: Send) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message).update(HEADERS)
        await send(message)

    return sent
