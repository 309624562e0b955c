"""Reading the API's requests, and answering those that cannot be done."""

from __future__ import annotations

from http import HTTPStatus
from typing import Any, TypeVar

import msgspec
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from voz.apps.web.access_middleware import MAX_BODY_BYTES
from voz.errors import ConfigError, VozError

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
