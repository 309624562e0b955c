"""Which utterances belong to which stretch of a stream. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

Stretch = tuple[float, float]
"""Start and end in a stream, s."""


class HasTimes(Protocol):
    """Something with a start and an end, s."""

    @property
    def start(self) -> float:
        """Where it begins, s."""

    @property
    def end(self) -> float:
        """Where it ends, s."""


Heard = TypeVar("Heard", bound=HasTimes)


def assign_to_stretches(
    heard: Sequence[Heard], stretches: Sequence[Stretch]
) -> tuple[list[list[Heard]], list[Heard]]:
    """Return the utterances in each stretch, and those outside of all.

    What overlaps with two stretches belongs to the earlier one, wherever that stands in the list.
    """
    parts: list[list[Heard]] = [[] for _ in stretches]
    rest: list[Heard] = []
    by_time = sorted(range(len(stretches)), key=stretches.__getitem__)
    for utterance in heard:
        overlaps = (n for n in by_time if _overlap(utterance, stretches[n]))
        number = next(overlaps, None)
        (rest if number is None else parts[number]).append(utterance)
    return parts, rest


def seconds_outside(stretches: Sequence[Stretch], seconds: float) -> float:
    """How much of a stream of so many seconds is in no stretch, s."""
    said = covered = 0.0
    for start, end in sorted(stretches):
        said += max(0.0, min(end, seconds) - max(start, covered))
        covered = max(covered, end)
    return max(0.0, seconds - said)


def _overlap(utterance: HasTimes, stretch: Stretch) -> bool:
    start, end = stretch
    return utterance.end > start and utterance.start < end
