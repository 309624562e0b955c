"""Files whose tests wait and files whose tests compute come by turns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

WAITING = {"audio", "hearing", "ros1", "ros2", "run", "speech", "web"}
"""Rooms whose tests mostly wait: for sound as long as it is, for other programs, for a browser."""


def by_turns(files: Sequence[str], waits: Sequence[bool]) -> list[int]:
    """Spread those that wait evenly among those that do not, each kind in the order it had.

    Args:
        files: of each test, its own.
        waits: whether it does.

    Returns:
        The places of the tests in their new order; those of a file stay together.
    """
    places: dict[str, float] = {}
    so_far = {True: 0, False: 0}
    for file, each in zip(files, waits, strict=True):
        places.setdefault(file, so_far[each] / waits.count(each))
        so_far[each] += 1
    return sorted(range(len(files)), key=lambda number: (places[files[number]], files[number]))


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Order them so for workers side by side: two that compute get half a processor each."""
    if not hasattr(config, "workerinput"):
        return
    here = Path(__file__).parent
    files = [str(item.path.relative_to(here)) for item in items]
    waits = [not WAITING.isdisjoint(Path(file).parts) for file in files]
    items[:] = [items[number] for number in by_turns(files, waits)]
