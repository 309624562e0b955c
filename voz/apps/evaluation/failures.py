"""Which clips went wrong, and in what way, the worst first. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from voz.apps.evaluation.results import Result, Understood

ALARM_CONTEXT = 0.5
"""Sound kept before and after a false alarm, s."""

OBEYED, MISHEARD, REFUSED, UNHEARD, UNREAD = (
    "obeyed what was not said",
    "heard wrongly",
    "refused",
    "heard nothing",
    "could not be read",
)
WORST_FIRST = (OBEYED, MISHEARD, REFUSED, UNHEARD, UNREAD)


@dataclass(frozen=True)
class Failure:
    """A clip that went wrong, or a stretch of it."""

    number: int  # of the result
    what: str  # one of `WORST_FIRST`
    heard: tuple[Understood, ...]
    stretch: tuple[float, float] | None = None  # start and end, s; None for all of the clip


def failures(results: Sequence[Result]) -> list[Failure]:
    """Find what went wrong, the worst first."""
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
    else:  # perhaps hours long: only what was obeyed is a failure
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
    """Where a clip is in its stream, s; None if it is a recording of its own."""
    if result.start is None or result.end is None:
        return None
    return result.start, result.end
