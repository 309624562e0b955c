"""Finds the sentences nearest to one, by any distance of words; pure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import lru_cache
from heapq import nsmallest
from operator import itemgetter
from typing import NamedTuple, Protocol

from voz.language.sentences.automaton import NO_LABEL, Automaton

BEAM_WIDTH = 64
"""Beginnings that are continued at each word."""

MAX_SUBSTITUTES = 16
"""Words that are tried in place of another, the cheapest."""


MAX_COMPARED_WORDS = 64
"""Candidates whose cost is computed, the cheapest by `rough_cost`."""


class WordCosts(Protocol):
    """Costs of edits of words."""

    def substitution_cost(self, word: str, other: str) -> float:
        """Cost of one word in place of another."""

    def rough_cost(self, word: str, other: str) -> float:
        """A fast estimate of the same."""

    def gap_cost(self, word: str) -> float:
        """Cost of leaving a word out, or inserting it."""


class LetterDistances:
    """`WordCosts` by the letters that differ."""

    def __init__(self) -> None:
        """Begin with an empty cache."""
        self.substitution_cost = lru_cache(maxsize=10_000)(self._instead)

    def _instead(self, word: str, other: str) -> float:
        alike = SequenceMatcher(None, word, other, autojunk=False).ratio()
        return (1 - alike) * max(len(word), len(other))

    def rough_cost(self, word: str, other: str) -> float:
        """Count the letters that only one of two words has."""
        return len(set(word) ^ set(other))

    def gap_cost(self, word: str) -> float:
        """Half the letters: a missing word is half a mistake."""
        return len(word) / 2 + 0.5


@dataclass(frozen=True)
class Neighbor:
    """A sentence and the cost of the edits to it."""

    cost: float
    sentence: str


class _Begun(NamedTuple):
    cost: float
    changes: int
    state: int
    words: tuple[str, ...]


def nearest(
    automaton: Automaton, said: Sequence[str], costs: WordCosts, most: int, changes: int = 2
) -> list[Neighbor]:
    """Find the sentences that are nearest to some words, without these, the nearest first.

    The words need not be a sentence. `most` sentences at most, by `changes` edits at most.
    """
    found: dict[tuple[str, ...], float] = {}
    replacing = lru_cache(None)(lambda state, word: _replacing(automaton, costs, state, word))
    begun = [_Begun(0.0, 0, 0, ())]
    for at, word in enumerate([*said, None]):
        begun = _with_more(automaton, costs, begun, changes)
        _finish(automaton, begun, said[at:], found)
        if word is None:
            break
        following = []
        for one in begun:
            if (to := automaton.arcs[one.state].get(word)) is not None:
                following.append(_Begun(one.cost, one.changes, to, (*one.words, word)))
            if one.changes < changes:
                more = one.changes + 1
                following.append(
                    _Begun(one.cost + costs.gap_cost(word), more, one.state, one.words)
                )
                following += (
                    _Begun(one.cost + cost, more, to, (*one.words, other))
                    for cost, other, to in replacing(one.state, word)
                )
        _finish(automaton, following, said[at + 1 :], found)
        begun = nsmallest(BEAM_WIDTH, following, key=itemgetter(0))
    found.pop(tuple(said), None)
    ordered = nsmallest(most, found.items(), key=itemgetter(1))
    return [Neighbor(cost, " ".join(words)) for words, cost in ordered]


def _with_more(
    automaton: Automaton, costs: WordCosts, begun: list[_Begun], changes: int
) -> list[_Begun]:
    """Add what begins the same with inserted words."""
    every, last = list(begun), begun
    while last := [one for one in last if one.changes < changes]:
        longer = [
            _Begun(one.cost + costs.gap_cost(word), one.changes + 1, to, (*one.words, word))
            for one in last
            for word, to in _cheapest(automaton, costs, one.state)
        ]
        last = nsmallest(BEAM_WIDTH, longer, key=itemgetter(0))
        every += last
    return every


def _cheapest(automaton: Automaton, costs: WordCosts, state: int) -> list[tuple[str, int]]:
    return nsmallest(
        MAX_SUBSTITUTES, automaton.arcs[state].items(), key=lambda arc: costs.gap_cost(arc[0])
    )


def _replacing(
    automaton: Automaton, costs: WordCosts, state: int, word: str
) -> list[tuple[float, str, int]]:
    arcs: Iterable[tuple[str, int]] = automaton.arcs[state].items()
    if len(automaton.arcs[state]) > MAX_COMPARED_WORDS:
        arcs = nsmallest(MAX_COMPARED_WORDS, arcs, key=lambda arc: costs.rough_cost(word, arc[0]))
    every = (
        (costs.substitution_cost(word, other), other, to) for other, to in arcs if other != word
    )
    return nsmallest(MAX_SUBSTITUTES, every)


def _finish(
    automaton: Automaton,
    begun: Sequence[_Begun],
    rest: Sequence[str],
    found: dict[tuple[str, ...], float],
) -> None:
    """Add the sentences that continue with the unchanged rest."""
    for one in begun:
        end = automaton.walk(rest, one.state)
        if end is not None and automaton.labels[end] != NO_LABEL:
            words = (*one.words, *rest)
            found[words] = min(one.cost, found.get(words, one.cost))
