"""A page that shows a session that was kept, at any time of it; nothing can be driven there."""

from __future__ import annotations

import threading

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from voz.apps.web.app import FILES
from voz.apps.web.board import Record, encoded
from voz.apps.web.guard import Guard
from voz.apps.web.server import serving
from voz.apps.web.site import Site
from voz.errors import ConfigError


def show_session(site: Site, session: Record) -> None:
    """Serve a session until a signal ends the program.

    Args:
        site: where the page is, and who may come.
        session: what `session_record` gave.

    Raises:
        ConfigError: the server failed.
    """
    body = encoded(session).encode()
    failed = threading.Event()
    reasons: list[str] = []

    async def index(_: Request) -> Response:
        return FileResponse(FILES / "session.html")

    async def all_of_it(_: Request) -> Response:
        return Response(body, media_type="application/json")

    def fail(reason: str) -> None:
        reasons.append(reason)
        failed.set()

    routes = [Route("/", index), Route("/api/session", all_of_it)]
    app = Starlette(routes=[*routes, Mount("/page", StaticFiles(directory=FILES))])
    with serving(Guard(app, site.doors, site.at), site.at, site.tls, list, fail):
        failed.wait()
    raise ConfigError(f"{reasons[0]}; start it anew")
