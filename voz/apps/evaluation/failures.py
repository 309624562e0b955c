"""Which clips went wrong, and in what way, the worst first. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from voz.apps.evaluation.results import Result, Understood

ALARM_CONTEXT = 0.5
"""So much is heard before and after what was obeyed in talk, s."""

OBEYED, MISHEARD, REFUSED, UNHEARD, UNREAD = (
    "obeyed what was not said",
    "heard wrongly",
    "refused",
    "heard nothing",
    "could not be read",
)
WORST_FIRST = (OBEYED, MISHEARD, REFUSED, UNHEARD, UNREAD)


class Failure(NamedTuple):
    """A clip that went wrong, or a stretch of it.

    Attributes:
        number: which result.
        what: went wrong; one of `WORST_FIRST`.
        heard: what was heard there.
        stretch: where it is in what was heard, from when to when, s; None for all of it.
    """

    number: int
    what: str
    heard: tuple[Understood, ...]
    stretch: tuple[float, float] | None = None


def failures(results: Sequence[Result]) -> list[Failure]:
    """Find what went wrong.

    Args:
        results: of each clip.
    """
    found = [failure for n, result in enumerate(results) for failure in _failures(n, result)]
    return sorted(found, key=lambda failure: WORST_FIRST.index(failure.what))


def _failures(number: int, result: Result) -> Iterator[Failure]:
    if result.error is not None:
        yield Failure(number, UNREAD, ())
    elif result.kind in ("command", "long"):
        if not result.is_right_and_accepted:
            yield Failure(number, _what(result), result.heard, _said_at(result))
    elif result.kind == "near-miss":
        if result.obeyed:
            yield Failure(number, OBEYED, result.heard, _said_at(result))
    else:  # hours, perhaps: only what was obeyed is of interest
        for one in result.heard:
            if one.accepted:
                stretch = max(0.0, one.start - ALARM_CONTEXT), one.end + ALARM_CONTEXT
                yield Failure(number, OBEYED, (one,), stretch)


def _what(result: Result) -> str:
    if result.is_wrongly_obeyed:
        return OBEYED
    if not result.texts:
        return UNHEARD
    return REFUSED if result.is_right else MISHEARD


def _said_at(result: Result) -> tuple[float, float] | None:
    """Where a clip is in its stream; None if it is a recording of its own."""
    if result.start is None or result.end is None:
        return None
    return result.start, result.end
