"""Finds subscribers that do not acknowledge messages: a connection is not enough."""

from __future__ import annotations

from collections.abc import Set

ACKNOWLEDGE_TIMEOUT = 0.5
"""A subscriber that acknowledges nothing for this time, s, is gone.

DDS itself lists a killed program as connected for another 10 to 20 s.
"""


class SubscriberLiveness:
    """Finds subscribers that acknowledge nothing; time comes in with each call."""

    def __init__(self) -> None:
        self._asked: float | None = None
        self._silent: Set[int] = frozenset()

    def update(self, now: float, listeners: Set[int], answered: bool) -> None:
        """Note whether all connected listeners have acknowledged the last message."""
        if answered:
            self._asked, self._silent = None, frozenset()
        elif self._asked is None:
            self._asked = now
        elif now - self._asked >= ACKNOWLEDGE_TIMEOUT and not self._silent:
            # It is unknown which of them is silent; later ones are not.
            self._silent = frozenset(listeners)

    def alive(self, listeners: Set[int]) -> Set[int]:
        """Return those of the connected listeners that may be alive."""
        return listeners - self._silent
