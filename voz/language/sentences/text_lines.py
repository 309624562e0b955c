"""The text that a user wrote: its lines, and errors that show a place in it; pure."""

from __future__ import annotations

import codecs
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

from voz.errors import CommandsError

PRONUNCIATIONS_FILE = "pronunciations.txt"
"""Beside a list: how its words are pronounced, by its user."""

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


@dataclass(frozen=True, slots=True)
class Location:
    """A place in a file, for messages."""

    file: str  # what messages call the file
    line: int  # from 1
    column: int = 0  # from 1; 0 is the whole line
    text: str = ""  # the line

    def __str__(self) -> str:
        return f"{self.file}:{self.line}" + (f":{self.column}" if self.column else "")

    def excerpt(self) -> tuple[str, ...]:
        """The line with a caret below the column; empty if the column is unknown."""
        if not self.column:
            return ()
        text = self.text.replace("\t", " ").rstrip()
        return text, " " * (self.column - 1) + "^"


def error_at(place: Location, message: str) -> CommandsError:
    """An error that names and shows a place."""
    return CommandsError(f"{place}: {message}", excerpt=place.excerpt())


MAX_FAULTS = 20
"""Faults of a file that are told at once."""


class Faults:
    """Collects the faults of a file in `with` blocks, so that all are told at once."""

    def __init__(self) -> None:
        self._found: list[CommandsError] = []

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, _: object) -> bool:
        if isinstance(error, CommandsError):
            self._found.append(error)
        return isinstance(error, CommandsError) and len(self._found) < MAX_FAULTS

    def check(self) -> None:
        """Raise CommandsError for what was collected: the first fault, with the others below."""
        if self._found:
            first, *others = self._found
            below = (line for error in others for line in (str(error), *error.excerpt))
            raise CommandsError(first.problem, first.remedy, (*first.excerpt, *below))


@dataclass(frozen=True)
class Passage:
    """A piece of a file that is parsed."""

    file: str  # what messages call the file
    line: int  # the number of its first line, from 1
    column: int  # where it begins in that line, from 0
    text: str  # the piece; it may have several lines
    whole: str = ""  # its whole first line; empty if the piece is that line

    def place(self, at: int = 0) -> Location:
        """The location of a character in the file."""
        down = bisect_right(self._begins, at) - 1
        column = at - self._begins[down] + (0 if down else self.column)
        shown = self.whole if self.whole and not down else self._lines[down]
        return Location(self.file, self.line + down, column + 1, shown)

    # Split once: a grammar of thousands of rules is one passage, and each rule has a place in it.

    @cached_property
    def _lines(self) -> list[str]:
        return self.text.split("\n")

    @cached_property
    def _begins(self) -> list[int]:
        return [0, *accumulate(len(line) + 1 for line in self._lines)]

    def part(self, start: int, end: int | None = None) -> Passage:
        """A part of a passage that is one line."""
        whole = self.whole or self.text
        return Passage(self.file, self.line, self.column + start, self.text[start:end], whole)
