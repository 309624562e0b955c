"""Shows a recorded session (what `voz run --events` wrote, or a bag) on a page, at any time of it.

Nothing can be driven there.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from http import HTTPStatus
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import Any, TypeAlias

import msgspec
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from voz.apps.recordings.bags import is_bag, read_events
from voz.apps.recordings.manifest import MANIFEST_NAME, parse_lines
from voz.apps.recordings.recorder import EXCERPT_MARGIN
from voz.apps.web.page_language import PAGE_FILES, page_in_own_language
from voz.apps.web.page_messages import SHOWN_EVENTS, EventHistory, Record, encode_record
from voz.apps.web.picture import DeadReckoningPicture, RoomPicture
from voz.apps.web.web_server import PageAddress
from voz.audio import SAMPLE_RATE
from voz.errors import ConfigError
from voz.events import Event, Twist, Utterance
from voz.files import read_text, shown_path
from voz.robot.simulation.simulator import SimulatedRobot
from voz.robot.simulation.world import start
from voz.settings import Simulator

FOLDER_ADVICE = "name the folder of `voz run --record`"

UtteranceKey: TypeAlias = tuple[float, float, str]
"""Where an utterance begins and ends, s of the run, and what was heard."""

SESSION_ADVICE = "name what `voz run --events FILE` wrote, or a bag"


def read_session(path: Path) -> list[Event]:
    """Read the events of a run: lines of JSON, or a bag of ROS 1 or 2.

    Raises:
        ConfigError: it cannot be read, or has no event.
    """
    events = read_events(path) if is_bag(path) else _written(path)
    if not events:
        raise ConfigError(f"{shown_path(path)}: has no events; {SESSION_ADVICE}")
    return events


def read_recordings(folder: Path) -> dict[UtteranceKey, Path]:
    """Find what `voz run --record` kept of each utterance.

    Raises:
        ConfigError: there is no such folder, or it has no recording with its event.
    """
    manifest = folder / MANIFEST_NAME
    decoder = msgspec.json.Decoder(Utterance)
    found: dict[UtteranceKey, Path] = {}
    for line in parse_lines(read_text(manifest, ConfigError, FOLDER_ADVICE)):
        name, event = line.fields[0], line.fields[-1]
        with suppress(msgspec.DecodeError, RecursionError):
            if Path(name).name == name:  # a user's own rows may name others, and have no event
                found[utterance_key(decoder.decode(event))] = folder / name
    if not found:
        raise ConfigError(f"{shown_path(folder)}: has no recordings; {FOLDER_ADVICE}")
    return found


def utterance_key(utterance: Utterance) -> UtteranceKey:
    """Return by what an utterance is found: its record may have been made before it was obeyed."""
    return utterance.start, utterance.end, utterance.text


def _written(path: Path) -> list[Event]:
    """Read lines of JSON; a last one that was cut short is left out."""
    lines = read_text(path, ConfigError, SESSION_ADVICE).split("\n")
    decoder = msgspec.json.Decoder(Event)
    events: list[Event] = []
    for number, line in enumerate(lines[:-1], start=1):
        try:
            events.append(decoder.decode(line))
        except (msgspec.DecodeError, RecursionError) as error:
            why = f"is not an event of voz ({error})"
            raise ConfigError(f"{shown_path(path)}:{number}: {why}; {SESSION_ADVICE}") from None
    return events


State: TypeAlias = list[Any]
"""Time (s), x and y (m), heading (rad), speed (m/s), turning (rad/s), selected object or None.

In a room the points of the arm (m) too, and whether the robot touches something.
"""


def session_record(
    name: str,
    events: Sequence[Event],
    room: Simulator | None = None,
    recordings: Mapping[UtteranceKey, Path] | None = None,
) -> Record:
    """Return what was heard and said, and where the robot was: `states` has one for each change.

    The events are in the order of time, one at least, and become what pages get. The room is that
    of the simulated robot that drove; None for another robot, whose way is computed from its
    velocities.
    """
    states = _states_in_room(events, room) if room else _states(events)
    return {
        "name": name,
        "begin": events[0].t,
        "end": max(event.t for event in events),
        "room": RoomPicture(room, lambda: start(room)).room() if room else None,
        "states": [next(same) for _, same in groupby(states, itemgetter(slice(1, None)))],
        "events": _shown_events(events, recordings or {}),
    }


def _shown_events(events: Sequence[Event], recordings: Mapping[UtteranceKey, Path]) -> list[Record]:
    history = EventHistory(lambda _: None)
    shown = []
    for event in events:
        if not isinstance(event, SHOWN_EVENTS):
            continue
        record = history.add(event)
        if isinstance(event, Utterance) and (path := recordings.get(utterance_key(event))):
            begin = round(event.start - EXCERPT_MARGIN / SAMPLE_RATE, 3)
            record["sound"] = {"file": path.name, "begin": begin}
        shown.append(record)
    return shown


def _states(events: Sequence[Event]) -> Iterator[State]:
    picture = DeadReckoningPicture()
    for event in events:
        picture.receive(event)
        if isinstance(event, Twist):
            robot = picture.state()
            yield [event.t, *robot["pose"], event.linear, event.angular, robot["selected"]]


def _states_in_room(events: Sequence[Event], settings: Simulator) -> Iterator[State]:
    """Drive the simulated robot through its room again: the same events give the same way."""
    robot = SimulatedRobot(settings)
    twist = Twist(events[0].t, 0.0, 0.0)
    for event in events:
        robot.receive(event)
        world = robot.state_at(event.t)
        drawn = RoomPicture(settings, lambda world=world: world).state()  # type: ignore[misc]
        twist = event if isinstance(event, Twist) else twist
        moved = [*drawn["pose"], twist.linear, twist.angular, drawn["selected"]]
        yield [event.t, *moved, drawn["arm"], drawn["collided"]]


def show_session(
    address: PageAddress,
    session: Record,
    recordings: Mapping[UtteranceKey, Path] | None = None,
) -> None:
    """Serve a `session_record` and its sound until a signal ends the run; raises ConfigError."""
    files = {path.name: path for path in (recordings or {}).values()}
    body = encode_record(session).encode()
    failed = threading.Event()
    reasons: list[str] = []

    async def index(request: Request) -> Response:
        return page_in_own_language(request, "session.html")

    async def whole_session(_: Request) -> Response:
        return Response(body, media_type="application/json")

    async def recording(request: Request) -> Response:
        path = files.get(request.path_params["file"])
        if path is None or not path.is_file():
            return Response(status_code=HTTPStatus.NOT_FOUND)
        return FileResponse(path, media_type="audio/flac")

    def fail(reason: str) -> None:
        reasons.append(reason)
        failed.set()

    routes = [
        Route("/", index),
        Route("/api/session", whole_session),
        Route("/api/recordings/{file}", recording),
    ]
    app = Starlette(routes=[*routes, Mount("/page", StaticFiles(directory=PAGE_FILES))])
    with address.serving(app, list, fail):
        failed.wait()
    raise ConfigError(f"{reasons[0]}; start it again")
