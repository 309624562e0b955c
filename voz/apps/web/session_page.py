"""A page that shows a recorded session at any time of it; nothing can be driven there."""

from __future__ import annotations

import threading

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from voz.apps.web.control_api import PAGE_FILES
from voz.apps.web.event_history import Record, encode_record
from voz.apps.web.page_address import PageAddress
from voz.errors import ConfigError


def show_session(address: PageAddress, session: Record) -> None:
    """Serve a `session_record` until a signal ends the program; raises ConfigError."""
    body = encode_record(session).encode()
    failed = threading.Event()
    reasons: list[str] = []

    async def index(_: Request) -> Response:
        return FileResponse(PAGE_FILES / "session.html")

    async def whole_session(_: Request) -> Response:
        return Response(body, media_type="application/json")

    def fail(reason: str) -> None:
        reasons.append(reason)
        failed.set()

    routes = [Route("/", index), Route("/api/session", whole_session)]
    app = Starlette(routes=[*routes, Mount("/page", StaticFiles(directory=PAGE_FILES))])
    with address.serving(app, list, fail):
        failed.wait()
    raise ConfigError(f"{reasons[0]}; start it again")
