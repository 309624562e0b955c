"""The matrix as tables, for the documents: `tools/make_promises.py` writes them there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count
from string import ascii_lowercase
from typing import Protocol

from promises.doors import DOORS, LiveDoor
from promises.exits import EXITS
from promises.promises import PROMISES, Promise
from promises.run import Door, Given
from promises.test_exits import PROMISES as EXIT_PROMISES
from promises.test_losses import LOST_AT, Loss, losses_at, script

KEPT = "✓"


class Row(Protocol):
    """A door or an exit."""

    name: str
    cannot: Mapping[str, str]


class Promised(Protocol):
    """A promise of either."""

    name: str
    says: str


def matrix(rows: Sequence[Row], promises: Sequence[Promised]) -> Iterator[str]:
    """Yield the lines of a table: promises down, rows across by their numbers, and its legend."""
    reasons = dict(zip(_reasons(rows, promises), _marks(), strict=False))
    yield "".join(["| promise |", *(f"{n}|" for n in range(1, len(rows) + 1))])
    yield "|---" * (len(rows) + 1) + "|"
    for promise in promises:
        name = promise.name
        cells = (reasons[row.cannot[name]] if name in row.cannot else KEPT for row in rows)
        yield "".join([f"| **{name}**: {promise.says} |", *(f"{cell}|" for cell in cells)])
    yield ""
    yield "; ".join(f"**{number}** {row.name}" for number, row in enumerate(rows, 1))
    yield ""
    for reason, mark in reasons.items():
        yield f"- {mark}: {reason}"


def doors_table() -> list[str]:
    """The table of doors."""
    return [*matrix(DOORS, PROMISES)]


def exits_table() -> list[str]:
    """The table of exits."""
    return [*matrix(EXITS, EXIT_PROMISES)]


def times() -> Iterator[str]:
    """Run the matrix, and yield the lines of a table of how soon the robot stands."""
    yield "| | stands after `stop`, s | after a loss, s | and has moved by then, m |"
    yield "|---|---|---|---|"
    doors: dict[str, list[str]] = {}
    for door in DOORS:
        if [*_stops(door)]:
            doors.setdefault(_how_soon(door), []).append(door.name)
    for cells, names in doors.items():
        yield f"| {'; '.join(names)} | {cells} |"


def _how_soon(door: Door) -> str:
    """The cells of a door, of its slowest run."""
    stop = max(_after_stop(door, promise) for promise in _stops(door))
    losses = [_after_loss(door, loss) for loss in _losses(door)]
    if not losses:
        return f"{stop:.2f} | |"
    return f"{stop:.2f} | {max(s for s, _ in losses):.2f} | {max(m for _, m in losses):.3f}"


def _stops(door: Door) -> Iterator[Promise]:
    wanted = ("stop", "stop repeated", "stop, please", "stop in a flood", "stop speech")
    return (p for p in PROMISES if p.name in wanted and p.name not in door.cannot)


def _after_stop(door: Door, promise: Promise) -> float:
    """When it stood, after the stop was begun to be said, typed or tapped, s."""
    outcome = door.run(promise.given, promise.then, promise.seconds)
    begun = next(do.at for do in promise.then if "stop" in do.text)
    return outcome.stood_at(begun) - begun


def _losses(door: Door) -> Iterable[Loss]:
    others = ("stall", "press space")
    live = losses_at(door) if isinstance(door, LiveDoor) else []
    return [loss for loss in live if loss.lost not in others]


def _after_loss(door: Door, loss: Loss) -> tuple[float, float]:
    outcome = door.run(Given(), script(loss, loss, 0.0), LOST_AT + 4)
    stood = outcome.stood_at(LOST_AT)
    return stood - LOST_AT, outcome.meters(LOST_AT, stood)


def _reasons(rows: Sequence[Row], promises: Sequence[Promised]) -> Iterator[str]:
    """The reasons of a table, each once, as they come."""
    found = (row.cannot[p.name] for row in rows for p in promises if p.name in row.cannot)
    return iter(dict.fromkeys(found))


def _marks() -> Iterator[str]:
    for round_ in count():
        yield from (letter + (str(round_) if round_ else "") for letter in ascii_lowercase)
