"""The HTTP requests that show and drive a run; docs/operator-page-api.md has them."""

from __future__ import annotations

import asyncio
import io
import platform
import sys
import zipfile
from collections.abc import Callable, Iterable, Sequence
from http import HTTPStatus
from importlib.metadata import distributions
from typing import Any, TypeVar

import msgspec
from msgspec.structs import replace
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Mount, Route
from starlette.staticfiles import StaticFiles

from voz import __version__
from voz.apps.web.access_control import MAX_BODY_BYTES, AccessControl
from voz.apps.web.page_language import PAGE_FILES, page_in_own_language
from voz.apps.web.page_messages import Command, Login, Record, encode_record
from voz.apps.web.page_registry import OpenPage, PageRegistry
from voz.config import Config
from voz.errors import ConfigError, RobotError, VozError

MAX_STOP_DIGITS = 10
"""Of the number of a stop."""


class ControlApi:
    """Answers the requests that show and drive a run."""

    def __init__(
        self,
        registry: PageRegistry,
        access: AccessControl,
        snapshot: Callable[[], Record],
        settings: Config,
    ) -> None:
        """Prepare to answer; `snapshot` returns all that a page shows."""
        self._registry = registry
        self._access = access
        self._snapshot = snapshot
        self._settings = settings

    def routes(self) -> list[BaseRoute]:
        """The addresses that it answers."""
        return [
            Route("/api/state", self.state),
            Route("/api/diagnostics", self.diagnostics),
            Route("/api/login", self.login, methods=["POST"]),
            Route("/api/command", self.command, methods=["POST"]),
            Route("/api/stop", self.stop, methods=["POST"]),
        ]

    async def state(self, _: Request) -> Response:
        """GET /api/state: the current state, and the last events."""
        return JSONResponse(self._snapshot())

    async def diagnostics(self, _: Request) -> Response:
        """GET /api/diagnostics: a ZIP file for finding out what went wrong."""
        packed = await asyncio.to_thread(
            diagnostic_bundle, self._snapshot(), self._registry.recent, self._settings
        )
        headers = {"Content-Disposition": 'attachment; filename="voz-diagnostics.zip"'}
        return Response(packed, media_type="application/zip", headers=headers)

    async def login(self, request: Request) -> Response:
        """POST /api/login: exchanges the token for a cookie that scripts cannot read."""
        login = await decode_body(request, Login, "send JSON with token")
        session = self._access.log_in(login.token)
        if session is None:
            raise HTTPException(HTTPStatus.FORBIDDEN, "wrong token: open the link again")
        answer = JSONResponse({"ok": True})
        answer.set_cookie(
            self._access.cookie, session, path="/api", httponly=True, samesite="strict",
            secure=request.url.scheme == "https",
        )  # fmt: skip
        return answer

    async def command(self, request: Request) -> Response:
        """POST /api/command: obeys a sentence, and returns what became of it."""
        command = await decode_body(request, Command, 'send JSON such as {"text": "go forward"}')
        utterance = await self._registry.command(command.text, command.page, command.stops)
        return JSONResponse(msgspec.to_builtins(utterance))

    async def stop(self, request: Request) -> Response:
        """POST /api/stop: stops the robot, whoever asks; answers when it is stopped."""
        page = self._registry.page_with_secret(request.headers.get("X-Voz-Page", ""))
        number = request.headers.get("X-Voz-Stop", "")
        valid = number.isdecimal() and len(number) < MAX_STOP_DIGITS
        return JSONResponse(*await stop_answer(self._registry, page, int(number) if valid else 0))


async def stop_answer(
    registry: PageRegistry, page: OpenPage | None, number: int
) -> tuple[Record, HTTPStatus]:
    """Stop the robot; returns the answer to a page or a program."""
    try:
        return {"stopped": True, "t": await registry.stop(page, number)}, HTTPStatus.OK
    except RobotError as late:
        error = f"{late}: use the switch that cuts its power"
        return {"stopped": False, "error": error}, HTTPStatus.SERVICE_UNAVAILABLE


def application(routes: Sequence[BaseRoute], authority: bytes | None) -> Starlette:
    """Make the application: the API, and the files of the page.

    `authority` is the certificate that a phone has to trust, PEM; None without HTTPS.
    """

    async def index(request: Request) -> Response:
        return page_in_own_language(request, "index.html")

    async def certificate(_: Request) -> Response:
        if authority is None:
            raise HTTPException(HTTPStatus.NOT_FOUND, "this page needs no certificate")
        return Response(authority, media_type="application/x-x509-ca-cert")

    more = [Route("/", index), Route("/api/authority.crt", certificate)]
    files = Mount("/page", StaticFiles(directory=PAGE_FILES))
    return Starlette(routes=[*more, *routes, files], exception_handlers=ERROR_HANDLERS)


def diagnostic_bundle(state: Record, events: Iterable[str], settings: Config) -> bytes:
    """Return the ZIP file, without the settings of the user's own robots."""
    hidden = replace(settings, own={name: {} for name in settings.own})
    texts = {
        "state.json": encode_record(state),
        "events.jsonl": "\n".join(events),
        "settings.json": msgspec.json.format(msgspec.json.encode(hidden)).decode(),
        "versions.txt": "\n".join(_versions()),
    }
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
        for name, text in texts.items():
            file.writestr(name, text)
    return packed.getvalue()


def _versions() -> list[str]:
    packages = sorted({f"{each.name} {each.version}" for each in distributions()})
    return [f"voz {__version__}", f"Python {sys.version}", platform.platform(), "", *packages]


Message = TypeVar("Message")


async def decode_body(request: Request, kind: type[Message], advice: str) -> Message:
    """Read a body of JSON; raises HTTPException with the advice if it is invalid or too long."""
    body = b""
    # Another site's form can send any other type without asking.
    if request.headers.get("content-type", "").partition(";")[0] == "application/json":
        async for piece in request.stream():
            if len(body := body + piece) > MAX_BODY_BYTES:
                break
    message: Message | None = decode_json(body, kind) if len(body) <= MAX_BODY_BYTES else None
    if message is None:
        raise HTTPException(HTTPStatus.BAD_REQUEST, advice)
    return message


def decode_json(data: str | bytes | None, kind: Any) -> Any:
    """Read a message of JSON; None if it is invalid."""
    try:
        return msgspec.json.decode(data or b"", type=kind)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError):
        return None


def _answer_http_error(_: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    return JSONResponse({"error": error.detail}, error.status_code, error.headers)


def _answer_wrong_value(_: Request, error: Exception) -> Response:
    return JSONResponse({"error": str(error)}, HTTPStatus.BAD_REQUEST)


def _answer_failure(_: Request, error: Exception) -> Response:
    return JSONResponse({"error": str(error)}, HTTPStatus.SERVICE_UNAVAILABLE)


ERROR_HANDLERS: Any = {
    HTTPException: _answer_http_error,
    ConfigError: _answer_wrong_value,
    VozError: _answer_failure,
}
"""How errors are answered, as Starlette takes it."""
