"""Text of others, made safe for a terminal."""

import re
from reprlib import Repr

_ESCAPE_SEQUENCE = re.compile(
    r"\x1b(?:\][^\x07\x1b]*(?:\x07|\x1b\\)|\[[0-?]*[ -/]*[@-~])"  # titles, then colors and moves
)
_SHORT = Repr()
_SHORT.maxstring = _SHORT.maxother = 100


def printable(text: str) -> str:
    r"""Escape control characters of a line as Python does, such as `\x1b`, `\r` and `\u202e`."""
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text
    )


def shown_value(value: object) -> str:
    """Any object in a few characters, whatever its own `__repr__` does."""
    try:
        return printable(_SHORT.repr(value))
    except Exception:
        return f"an object of the type {type(value).__name__}"


def shown_text(value: object) -> str:
    """Any object as text, whatever its own `__str__` does."""
    try:
        return printable(str(value))
    except Exception:
        return shown_value(value)


def printable_output(line: str) -> str:
    """Make a line that another program printed safe, without its colors, tabs and end."""
    return printable(_ESCAPE_SEQUENCE.sub("", line).rstrip().expandtabs())
