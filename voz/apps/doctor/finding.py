"""What was found out about one part."""

from __future__ import annotations

from msgspec import Struct

from voz.errors import VozError


class Finding(Struct, frozen=True):
    """A part, and how it is.

    Attributes:
        what: the part.
        well: whether it does what it should.
        told: how it is, in words.
        to_do: what helps, if it is not well.
        needed: whether the robot does not obey, or not speak, without it.
    """

    what: str
    well: bool
    told: str
    to_do: str | None = None
    needed: bool = True


def not_well(what: str, error: VozError, needed: bool = True) -> Finding:
    """Make a finding of an error, which says what is wrong and, behind a semicolon, what to do."""
    told, _, to_do = str(error).partition("; ")
    return Finding(what, False, told, to_do or None, needed)
