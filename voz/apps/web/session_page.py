"""A page that shows a recorded session at any time of it; nothing can be driven there."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import TypeAlias

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from voz.apps.web.control_api import PAGE_FILES
from voz.apps.web.event_history import EventHistory, Record, encode_record
from voz.apps.web.page_address import PageAddress
from voz.apps.web.picture import DeadReckoningPicture
from voz.errors import ConfigError
from voz.events import Event, Partial, SelectedObject, Twist

State: TypeAlias = list[float | int | None]
"""Time (s), x and y (m), heading (rad), speed (m/s), turning (rad/s), selected object or None."""


def session_record(name: str, events: Sequence[Event]) -> Record:
    """Return what was heard and said, and where the robot was according to its velocities.

    There is one event at least. `states` has one for each change, `events` are as pages get them.
    """
    history = EventHistory(lambda _: None)
    shown = [history.add(e) for e in events if not isinstance(e, Twist | Partial | SelectedObject)]
    return {
        "name": name,
        "begin": events[0].t,
        "end": max(event.t for event in events),
        "states": _states(events),
        "events": shown,
    }


def _states(events: Sequence[Event]) -> list[State]:
    picture = DeadReckoningPicture()
    states: list[State] = []
    for event in events:
        picture.receive(event)
        if isinstance(event, Twist):
            robot = picture.state()
            state = [event.t, *robot["pose"], event.linear, event.angular, robot["selected"]]
            if not states or states[-1][1:] != state[1:]:
                states.append(state)
    return states


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
