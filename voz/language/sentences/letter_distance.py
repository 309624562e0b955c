"""How far apart two words are written; pure."""

from __future__ import annotations

from difflib import SequenceMatcher
from functools import lru_cache


class LetterDistances:
    """Costs by letters that differ, see `WordCosts`."""

    def __init__(self) -> None:
        """Begin with an empty cache."""
        self.substitution_cost = lru_cache(maxsize=10_000)(self._instead)

    def _instead(self, word: str, other: str) -> float:
        alike = SequenceMatcher(None, word, other, autojunk=False).ratio()
        return (1 - alike) * max(len(word), len(other))

    def rough_cost(self, word: str, other: str) -> float:
        """How many letters only one of two words has."""
        return len(set(word) ^ set(other))

    def gap_cost(self, word: str) -> float:
        """Half the letters: a missing word is half a mistake."""
        return len(word) / 2 + 0.5
