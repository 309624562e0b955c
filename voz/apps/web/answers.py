"""What requests and answers of the API have in common."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any, TypeVar

import msgspec
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from voz.apps.web.guard import MOST_BYTES

Kind = TypeVar("Kind")


async def decoded_body(request: Request, kind: type[Kind]) -> Kind | None:
    """Read a body of JSON; None if it is none, or too long."""
    if request.headers.get("content-type", "").partition(";")[0] != "application/json":
        return None  # what another site's form can send without asking
    body = b""
    async for piece in request.stream():
        body += piece
        if len(body) > MOST_BYTES:
            return None
    read: Kind | None = decoded(body, kind)
    return read


def decoded(data: str | bytes | None, kind: Any) -> Any:
    """Read a message of JSON; None if it is none of its kind."""
    try:
        return msgspec.json.decode(data or b"", type=kind)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError):
        return None


def refused(status: HTTPStatus, why: str) -> Response:
    """Answer that something is not done, and why."""
    return JSONResponse({"error": why}, status)
