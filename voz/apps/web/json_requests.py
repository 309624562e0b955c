"""Reading and answering the API's requests."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any, TypeVar

import msgspec
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from voz.apps.web.access_middleware import MAX_BODY_BYTES

Message = TypeVar("Message")


async def decode_body(request: Request, kind: type[Message]) -> Message | None:
    """Read a body of JSON; None if it is invalid or too long."""
    if request.headers.get("content-type", "").partition(";")[0] != "application/json":
        return None  # another site's form can send this without asking
    body = b""
    async for piece in request.stream():
        body += piece
        if len(body) > MAX_BODY_BYTES:
            return None
    message: Message | None = decode_json(body, kind)
    return message


def decode_json(data: str | bytes | None, kind: Any) -> Any:
    """Read a message of JSON; None if it is invalid."""
    try:
        return msgspec.json.decode(data or b"", type=kind)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError):
        return None


def error_response(status: HTTPStatus, why: str) -> Response:
    """Answer with an error."""
    return JSONResponse({"error": why}, status)
