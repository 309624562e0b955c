"""What two sequences have in common. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import takewhile
from typing import Any


def shared_ends(first: Sequence[Any], second: Sequence[Any]) -> tuple[int, int]:
    """Count the items that two sequences share at their beginning, and behind these at their end.

    Args:
        first: of any items that can be compared.
        second: the other.

    Returns:
        Both counts; together at most the length of the shorter sequence.
    """
    begin = _shared(first, second)
    return begin, _shared(reversed(first[begin:]), reversed(second[begin:]))


def _shared(first: Iterable[Any], second: Iterable[Any]) -> int:
    same = (one == other for one, other in zip(first, second, strict=False))
    return sum(1 for _ in takewhile(bool, same))
