"""The lines of a text file that a user wrote; pure."""

from __future__ import annotations

import codecs
from collections.abc import Iterator

from voz.errors import CommandsError

MAX_TEXT_BYTES = 1_000_000
MAX_WARNINGS = 10


def content_lines(data: bytes, name: str) -> Iterator[tuple[int, str]]:
    """Go through the lines of a text that hold more than a comment.

    Args:
        data: the bytes of the text; any line ends, with or without a byte order mark.
        name: what messages call the text.

    Yields:
        The number of the line, counted from 1, and the line without its comment and outer space.

    Raises:
        CommandsError: the text is too large or a line is not UTF-8.
    """
    for number, line in numbered_lines(data, name):
        text = line.partition("#")[0].strip(" \t")
        if text.strip():
            yield number, text


def numbered_lines(data: bytes, name: str) -> Iterator[tuple[int, str]]:
    """Go through all lines of a text as they are; the rest is as with `content_lines`."""
    if len(data) > MAX_TEXT_BYTES:
        raise CommandsError(f"{name}: is larger than {MAX_TEXT_BYTES:,} bytes; make it smaller")
    data = data.removeprefix(codecs.BOM_UTF8).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    for number, line in enumerate(data.split(b"\n"), start=1):
        try:
            yield number, line.decode("utf-8")
        except UnicodeDecodeError:
            raise CommandsError(
                f"{name}:{number}: is not UTF-8 text; save the file as UTF-8"
            ) from None


def summarize_warnings(warnings: list[str], summary: str) -> tuple[str, ...]:
    """Keep a few warnings as they are, and replace many by one that sums them up."""
    return tuple(warnings) if len(warnings) <= MAX_WARNINGS else (summary,)
