"""The addresses of the server: the page's files, and the API; docs/operator-page.md has them."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from http import HTTPStatus
from pathlib import Path
from typing import Any

import msgspec
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from voz.apps.web.answers import decoded, decoded_body, refused
from voz.apps.web.asking import NotDone
from voz.apps.web.board import Record, encoded
from voz.apps.web.desk import Desk, OvertakenError, TakenError, TooManyError
from voz.apps.web.diagnostics import bundle
from voz.apps.web.doors import Doors
from voz.apps.web.limits import Limit
from voz.apps.web.messages import (
    Command,
    Drive,
    FromMicrophone,
    FromPage,
    Hello,
    Leave,
    Login,
    Rehearse,
    Seen,
    Stop,
)
from voz.apps.web.page_sound import PageSound
from voz.apps.web.watcher import Watcher
from voz.config import Config

FILES = Path(__file__).with_name("page")

MESSAGES_EACH_SECOND, MESSAGES_AT_ONCE = 40.0, 200.0
"""Of one page, besides sound: it answers ten states a second."""

LATE_EACH_SECOND = 2.0
"""How often a page is told that its sound is late."""

MOST_DIGITS = 10
"""Of how often a page has asked for a stop."""

ASKED_EVERY = 1.0
"""How often a page that is heard is asked for its time, s."""

FULL, SLOW, WRONG, TOO_MUCH = 1013, 1013, 1008, 1009
"""Why a WebSocket is closed: try later, too slow, against the rules, too much at a time."""


class Api:
    """Answers what is asked under /api."""

    def __init__(
        self,
        desk: Desk,
        doors: Doors,
        look: Callable[[], Record],
        about: Callable[[], Record],
        settings: Config,
    ) -> None:
        """Prepare to answer.

        Args:
            desk: knows the pages.
            doors: lets them in.
            look: gives how things are now.
            about: tells what hardly changes: the commands, the room.
            settings: of the run, for who asks what went wrong.
        """
        self._desk = desk
        self._doors = doors
        self._look = look
        self._about = about
        self._settings = settings

    def routes(self) -> list[BaseRoute]:
        """All addresses under /api."""
        return [
            Route("/api/state", self.state),
            Route("/api/diagnostics", self.diagnostics),
            Route("/api/login", self.login, methods=["POST"]),
            Route("/api/command", self.command, methods=["POST"]),
            Route("/api/stop", self.stop, methods=["POST"]),
            WebSocketRoute("/api/events", self.events),
            WebSocketRoute("/api/audio", self.audio),
        ]

    async def state(self, _: Request) -> Response:
        """GET /api/state: how things are, and what was last."""
        return JSONResponse(self._all())

    async def diagnostics(self, _: Request) -> Response:
        """GET /api/diagnostics: what helps to find out what went wrong."""
        packed = await asyncio.to_thread(bundle, self._all(), self._desk.recent, self._settings)
        headers = {"Content-Disposition": 'attachment; filename="voz-diagnostics.zip"'}
        return Response(packed, media_type="application/zip", headers=headers)

    async def login(self, request: Request) -> Response:
        """POST /api/login: changes the token for a cookie that scripts cannot read."""
        login = await decoded_body(request, Login)
        session = self._doors.enter(login.token) if login else None
        if session is None:
            return refused(HTTPStatus.FORBIDDEN, "that is not the token: open the link anew")
        answer = JSONResponse({"ok": True})
        answer.set_cookie(
            self._doors.cookie, session, path="/api", httponly=True, samesite="strict",
            secure=request.url.scheme == "https",
        )  # fmt: skip
        return answer

    async def command(self, request: Request) -> Response:
        """POST /api/command: obeys a sentence, and tells what became of it."""
        command = await decoded_body(request, Command)
        if command is None:
            return refused(HTTPStatus.BAD_REQUEST, 'send JSON such as {"text": "go forward"}')
        try:
            utterance = await self._desk.command(command.text, command.page, command.stops)
        except TakenError:
            return refused(
                HTTPStatus.CONFLICT, "another page drives, or none: take the wheel first"
            )
        except TooManyError:
            return refused(HTTPStatus.TOO_MANY_REQUESTS, "too many commands at a time")
        except OvertakenError:
            return refused(HTTPStatus.CONFLICT, "a stop came after it: give it again")
        except NotDone:
            return refused(HTTPStatus.SERVICE_UNAVAILABLE, "the control loop does not answer")
        return JSONResponse(msgspec.to_builtins(utterance))

    async def stop(self, request: Request) -> Response:
        """POST /api/stop: stops the robot, whoever asks; answers when it is stopped."""
        page = self._desk.page_of(request.headers.get("X-Voz-Page", ""))
        number = request.headers.get("X-Voz-Stop", "")
        known = number.isdecimal() and len(number) < MOST_DIGITS
        return JSONResponse(*await self._stopped(page, int(number) if known else 0))

    async def events(self, socket: WebSocket) -> None:
        """WS /api/events: what a page is told, and what it asks for."""
        await socket.accept()
        if self._desk.full:
            await socket.close(FULL, "too many pages are open")
            return
        address = socket.client.host if socket.client else "?"
        with self._desk.watching(address) as watcher:
            watcher.put(encoded({**self._all(), "type": "welcome", **_identity(watcher)}))
            sending = asyncio.create_task(_send(socket, watcher))
            try:
                await self._listen(socket, watcher)
            finally:
                sending.cancel()
                with suppress(asyncio.CancelledError):
                    await sending

    async def audio(self, socket: WebSocket) -> None:
        """WS /api/audio: the sound of the page that drives."""
        await socket.accept()
        hello = decoded(await _text(socket), FromMicrophone)
        page = self._desk.page_of(hello.page) if isinstance(hello, Hello) else None
        microphone = self._desk.microphone
        if not microphone or not page or not isinstance(hello, Hello):
            await _close(socket, WRONG, "nobody listens to this page")
            return
        sound = PageSound(microphone, hello.rate)
        asking = asyncio.create_task(_ask(socket))
        try:
            await self._hear(socket, page, sound)
        finally:
            asking.cancel()
            if self._desk.drives(page):
                sound.close()

    async def _listen(self, socket: WebSocket, watcher: Watcher) -> None:
        """Take what a page asks for, until it goes or sends what it may not."""
        limit = Limit(MESSAGES_EACH_SECOND, MESSAGES_AT_ONCE)
        while (text := await _text(socket)) is not None:
            message = decoded(text, FromPage)
            if message is None or not limit.allows(time.monotonic()):
                await _close(socket, WRONG, "that is no message of this page, or too many")
                return
            if isinstance(message, Seen):
                self._desk.seen(watcher)
            elif isinstance(message, Drive):
                driving = self._desk.drive(watcher, message.over)
                watcher.put(encoded({"type": "drive", "driving": driving, **self._desk.pages}))
            elif isinstance(message, Leave):
                self._desk.leave(watcher)
            elif isinstance(message, Rehearse):
                self._desk.rehearse(watcher, message.on)
            elif isinstance(message, Stop):
                _detached(self._stop_by(watcher, message.number))

    async def _hear(self, socket: WebSocket, page: Watcher, sound: PageSound) -> None:
        """Take the sound of a page, while it drives."""
        tell = Limit(LATE_EACH_SECOND, 1.0)
        while (message := await _message(socket)) is not None:
            if not self._desk.drives(page):
                await _close(socket, WRONG, "this page does not drive")
                return
            text, data = message.get("text"), message.get("bytes")
            try:
                if data is not None:
                    late = sound.block(data)
                    if late is not None and tell.allows(time.monotonic()):
                        await socket.send_text(encoded({"type": "late", "seconds": late}))
                elif not sound.message(_checked(text)):
                    raise ValueError
            except ValueError:
                await _close(socket, TOO_MUCH, "that is no sound of this page, or too much")
                return

    async def _stop_by(self, watcher: Watcher, number: int) -> None:
        answer, _ = await self._stopped(watcher, number)
        watcher.put(encoded({"type": "stop", "number": number, **answer}))

    async def _stopped(self, page: Watcher | None, number: int) -> tuple[Record, HTTPStatus]:
        try:
            return {"stopped": True, "t": await self._desk.stop(page, number)}, HTTPStatus.OK
        except NotDone:
            error = "the control loop does not answer: use the switch that cuts its power"
            return {"stopped": False, "error": error}, HTTPStatus.SERVICE_UNAVAILABLE

    def _all(self) -> Record:
        events = {"events": self._desk.remembered}
        return {**self._about(), **events, "now": {**self._look(), **self._desk.pages}}


def application(routes: Sequence[BaseRoute], authority: bytes | None) -> Starlette:
    """Make the application: the API, and the files of the page.

    Args:
        routes: all that is under /api but the certificate.
        authority: the certificate that a phone has to trust, PEM; None without HTTPS.
    """

    async def index(_: Request) -> Response:
        return FileResponse(FILES / "index.html")

    async def certificate(_: Request) -> Response:
        if authority is None:
            return refused(HTTPStatus.NOT_FOUND, "this page needs no certificate")
        return Response(authority, media_type="application/x-x509-ca-cert")

    more = [Route("/", index), Route("/api/authority.crt", certificate)]
    files = Mount("/page", StaticFiles(directory=FILES))
    return Starlette(routes=[*more, *routes, files])


_running: set[asyncio.Task[None]] = set()


def _detached(work: Any) -> None:
    """Let something go on by itself: a stop must not wait for the one before it."""
    task = asyncio.create_task(work)
    _running.add(task)  # the loop itself holds none
    task.add_done_callback(_running.discard)


def _identity(watcher: Watcher) -> Record:
    return {"page": watcher.number, "name": watcher.name, "secret": watcher.secret}


async def _send(socket: WebSocket, watcher: Watcher) -> None:
    with suppress(WebSocketDisconnect, RuntimeError):
        while not watcher.too_slow:
            for record in await watcher.take():
                await socket.send_text(record)
        await socket.close(SLOW, "this page is too slow to follow")


async def _ask(socket: WebSocket) -> None:
    """Ask a page for its time again and again: clocks drift, and are set."""
    with suppress(WebSocketDisconnect, RuntimeError):
        while True:
            await socket.send_text(encoded({"type": "ping", "t": time.monotonic()}))
            await asyncio.sleep(ASKED_EVERY)


def _checked(text: str | None) -> Any:
    message = decoded(text, FromMicrophone)
    if message is None:
        raise ValueError
    return message


async def _message(socket: WebSocket) -> Any:
    """Take what a page sends next; None once it has gone."""
    try:
        message = await socket.receive()
    except RuntimeError:  # it was closed from here
        return None
    return message if message["type"] == "websocket.receive" else None


async def _text(socket: WebSocket) -> str | None:
    message = await _message(socket)
    return None if message is None else message.get("text") or ""


async def _close(socket: WebSocket, code: int, why: str) -> None:
    with suppress(RuntimeError, WebSocketDisconnect):
        await socket.close(code, why)
