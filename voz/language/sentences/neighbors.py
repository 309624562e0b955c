"""The sentences nearest to one, by whatever distance of words; pure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from heapq import nsmallest
from operator import itemgetter
from typing import NamedTuple, Protocol

from voz.language.sentences.automaton import NONE, Network

BEAM = 64
"""Beginnings that are followed up at each word; those with one change are all looked at."""

OTHERS = 16
"""Words that are tried in the place of another, the nearest of those that may stand there."""


LOOKED_AT = 64
"""Of more words that may stand in the place of another, those are compared that seem nearest."""


class Costs(Protocol):
    """How far apart words are."""

    def instead(self, word: str, other: str) -> float:
        """What it costs to take one word for another."""

    def rough(self, word: str, other: str) -> float:
        """The same at a glance, to choose those that are worth a closer look."""

    def alone(self, word: str) -> float:
        """What it costs to leave a word out, or to put it in."""


class Near(NamedTuple):
    """A sentence and what it costs to take another for it."""

    cost: float
    sentence: str


class _Begun(NamedTuple):
    cost: float
    changes: int
    state: int
    words: tuple[str, ...]


def nearest(
    network: Network, said: Sequence[str], costs: Costs, most: int, changes: int = 2
) -> list[Near]:
    """Find the sentences that are nearest to one.

    Args:
        network: the sentences.
        said: words, which need be no sentence.
        costs: how far apart words are.
        most: how many at most.
        changes: words that may be another, too many or too few.

    Returns:
        The sentences, the nearest first, without that itself.
    """
    found: dict[tuple[str, ...], float] = {}
    replacing = lru_cache(None)(lambda state, word: _replacing(network, costs, state, word))
    begun = [_Begun(0.0, 0, 0, ())]
    for at, word in enumerate([*said, None]):
        begun = _with_more(network, costs, begun, changes)
        _finish(network, begun, said[at:], found)
        if word is None:
            break
        following = []
        for one in begun:
            if (to := network.arcs[one.state].get(word)) is not None:
                following.append(_Begun(one.cost, one.changes, to, (*one.words, word)))
            if one.changes < changes:
                more = one.changes + 1
                following.append(_Begun(one.cost + costs.alone(word), more, one.state, one.words))
                following += (
                    _Begun(one.cost + cost, more, to, (*one.words, other))
                    for cost, other, to in replacing(one.state, word)
                )
        _finish(network, following, said[at + 1 :], found)
        begun = nsmallest(BEAM, following, key=itemgetter(0))
    found.pop(tuple(said), None)
    ordered = nsmallest(most, found.items(), key=itemgetter(1))
    return [Near(cost, " ".join(words)) for words, cost in ordered]


def _with_more(network: Network, costs: Costs, begun: list[_Begun], changes: int) -> list[_Begun]:
    """Add what begins the same with a word more, or with several."""
    every, last = list(begun), begun
    while last := [one for one in last if one.changes < changes]:
        longer = [
            _Begun(one.cost + costs.alone(word), one.changes + 1, to, (*one.words, word))
            for one in last
            for word, to in _cheapest(network, costs, one.state)
        ]
        last = nsmallest(BEAM, longer, key=itemgetter(0))
        every += last
    return every


def _cheapest(network: Network, costs: Costs, state: int) -> list[tuple[str, int]]:
    return nsmallest(OTHERS, network.arcs[state].items(), key=lambda arc: costs.alone(arc[0]))


def _replacing(
    network: Network, costs: Costs, state: int, word: str
) -> list[tuple[float, str, int]]:
    arcs: Iterable[tuple[str, int]] = network.arcs[state].items()
    if len(network.arcs[state]) > LOOKED_AT:
        arcs = nsmallest(LOOKED_AT, arcs, key=lambda arc: costs.rough(word, arc[0]))
    every = ((costs.instead(word, other), other, to) for other, to in arcs if other != word)
    return nsmallest(OTHERS, every)


def _finish(
    network: Network,
    begun: Sequence[_Begun],
    rest: Sequence[str],
    found: dict[tuple[str, ...], float],
) -> None:
    """Note the sentences that go on with the rest as it is."""
    for one in begun:
        end = network.walk(rest, one.state)
        if end is not None and network.labels[end] != NONE:
            words = (*one.words, *rest)
            found[words] = min(one.cost, found.get(words, one.cost))
