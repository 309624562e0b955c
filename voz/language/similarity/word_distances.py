"""Distances between words by their sound; pure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

from voz.language.acoustics.phone_distances import PhoneDistances, read_distances
from voz.language.similarity.confusion import loss_between

GAP_COST = 22.0
"""Nats for each phone of a word that is too many or too few.

Its frames are explained by its neighbors, or three of theirs by it: about 4 nats each.
"""

MAX_PRONUNCIATIONS = 2
"""Of a word, that are compared."""


class WordDistances:
    """Costs by how words sound, in nats that the recognizer would lose; see `WordCosts`."""

    def __init__(
        self,
        spellings: Mapping[str, Sequence[Sequence[str]]],
        distances: PhoneDistances | None = None,
    ) -> None:
        """Take the phones of each word; without distances, those of English phones."""
        self._distances = distances or read_distances()
        self._spellings = {
            word: [tuple(way) for way in ways[:MAX_PRONUNCIATIONS]]
            for word, ways in spellings.items()
        }
        self._phones = {word: frozenset(ways[0]) for word, ways in self._spellings.items()}
        self.substitution_cost = lru_cache(maxsize=100_000)(self._instead)

    def _instead(self, word: str, other: str) -> float:
        ways, others = self._spellings[word], self._spellings[other]
        return min(loss_between(one, two, self._distances) for one in ways for two in others)

    def rough_cost(self, word: str, other: str) -> float:
        """Count the phones that only one of two words has."""
        return len(self._phones[word] ^ self._phones[other])

    def gap_cost(self, word: str) -> float:
        """Cost of leaving a word out, or inserting it."""
        return GAP_COST * len(self._spellings[word][0])

    def phones(self, words: str) -> str:
        """Return the phones of some words, as they are usually said."""
        return " ".join(phone for word in words.split() for phone in self._spellings[word][0])
