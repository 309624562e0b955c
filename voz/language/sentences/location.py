"""Places in files, and errors that show them; pure."""

from __future__ import annotations

from dataclasses import dataclass

from voz.errors import CommandsError


@dataclass(frozen=True, slots=True)
class Location:
    """A place in a file, for messages.

    Attributes:
        file: what messages call the file.
        line: from 1.
        column: from 1; 0 is the whole line.
        text: the line.
    """

    file: str
    line: int
    column: int = 0
    text: str = ""

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
