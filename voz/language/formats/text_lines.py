"""The lines of a text file that a user wrote; pure."""

from __future__ import annotations

import codecs
from collections.abc import Iterator

from voz.errors import CommandsError

MAX_TEXT_BYTES = 1_000_000
MAX_WARNINGS = 10


def content_lines(data: bytes, name: str) -> Iterator[tuple[int, str]]:
    """Yield numbered lines without comments, outer space and empty lines; raises CommandsError."""
    for number, line in numbered_lines(data, name):
        text = line.partition("#")[0].strip(" \t")
        if text.strip():
            yield number, text


def numbered_lines(data: bytes, name: str) -> Iterator[tuple[int, str]]:
    """Number all lines of UTF-8 text, from 1, whatever ends them; raises CommandsError."""
    if len(data) > MAX_TEXT_BYTES:
        raise CommandsError(f"{name}: larger than {MAX_TEXT_BYTES:,} bytes; make it smaller")
    data = data.removeprefix(codecs.BOM_UTF8).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    for number, line in enumerate(data.split(b"\n"), start=1):
        try:
            yield number, line.decode("utf-8")
        except UnicodeDecodeError:
            raise CommandsError(
                f"{name}:{number}: is not UTF-8 text; save the file as UTF-8"
            ) from None


def summarize_warnings(warnings: list[str], summary: str) -> tuple[str, ...]:
    """Keep a few warnings as they are, and replace many by a summary."""
    return tuple(warnings) if len(warnings) <= MAX_WARNINGS else (summary,)
