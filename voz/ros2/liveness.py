"""Whether anybody receives what is sent: being connected is not enough, someone has to answer."""

from __future__ import annotations

from collections.abc import Set

PATIENCE = 0.5
"""Who has acknowledged nothing for so long, s, is not there.

A program that is killed says no goodbye, and DDS itself takes it for alive for 10 or 20 s more.
"""


class Audience:
    """Notes what is not acknowledged; time comes in with each call."""

    def __init__(self) -> None:
        self._asked: float | None = None
        self._silent: Set[int] = frozenset()

    def note(self, now: float, listeners: Set[int], answered: bool) -> None:
        """Tell how the last message was received.

        Args:
            now: by any clock, s.
            listeners: who is connected.
            answered: whether all of them have acknowledged it.
        """
        if answered:
            self._asked, self._silent = None, frozenset()
        elif self._asked is None:
            self._asked = now
        elif now - self._asked >= PATIENCE and not self._silent:
            # It is not known which of them; who comes later is not meant.
            self._silent = frozenset(listeners)

    def present(self, listeners: Set[int]) -> Set[int]:
        """Those of the connected ones who may be taken for alive."""
        return listeners - self._silent
