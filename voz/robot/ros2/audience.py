"""Whether anybody receives what is sent: being connected is not enough, someone has to answer."""

from __future__ import annotations

from collections.abc import Set

PATIENCE = 5
"""After so many messages in a row that are not acknowledged nobody is there: 0.5 s of velocities.

A program that is killed says no goodbye, and DDS itself takes it for alive for 10 or 20 s more.
"""


class Audience:
    """Counts what is not acknowledged; knows neither the network nor the time."""

    def __init__(self) -> None:
        self._unanswered = 0
        self._silent: Set[int] = frozenset()

    def note(self, listeners: Set[int], answered: bool) -> None:
        """Tell how the last message was received.

        Args:
            listeners: who is connected.
            answered: whether all of them have acknowledged it.
        """
        if answered:
            self._unanswered, self._silent = 0, frozenset()
            return
        self._unanswered += 1
        if self._unanswered == PATIENCE:
            # It is not known which of them; who comes later is not meant.
            self._silent = frozenset(listeners)

    def present(self, listeners: Set[int]) -> Set[int]:
        """Those of the connected ones who may be taken for alive."""
        return listeners - self._silent
