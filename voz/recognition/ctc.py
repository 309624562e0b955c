"""Where in a sound each sentence fits best.

Viterbi through the lattice of connectionist temporal classification (Graves et al. 2006,
doi:10.1145/1143844.1143891), with a free beginning and end.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

Ways = Sequence[Sequence[int]]
"""All pronunciations of a word, as numbers of symbols."""


class Node(NamedTuple):
    """A symbol, and the nodes from which it is reached, itself among them."""

    symbol: int
    sources: Sequence[int]


class Lattice(NamedTuple):
    """Sentences side by side."""

    symbols: Places  # of each node
    sources: Places  # nodes that lead to each node, a column each, padded with their number
    starts: npt.NDArray[np.bool_]  # whether a sentence may begin at each node
    ends: Places  # nodes at which one may end, sentence by sentence
    firsts: Places  # where those of each sentence begin in `ends`


class Matches(NamedTuple):
    """Relative log-likelihood (nats), first and last moment of each sentence."""

    scores: Floats
    begins: Places
    ends: Places


def lattice(sentences: Iterable[Sequence[Ways]], blank: int) -> Lattice:
    """Build the lattice of sentences; no pronunciation may be empty."""
    nodes: list[Node] = []
    starts: list[int] = []
    ends: list[list[int]] = []
    for words in sentences:
        before: list[int] = []
        last: list[int] = []
        for place, word in enumerate(words):
            firsts, last = _append(nodes, word, before, blank)
            if place == 0:
                starts += firsts
            if place < len(words) - 1:
                nodes.append(Node(blank, [*last, len(nodes)]))
                before = [*last, len(nodes) - 1]
        ends.append(last)
    most = max(len(node.sources) for node in nodes)
    padded = [[*node.sources, *[len(nodes)] * (most - len(node.sources))] for node in nodes]
    is_start = np.zeros(len(nodes), np.bool_)
    is_start[starts] = True
    return Lattice(
        np.array([node.symbol for node in nodes]),
        np.array(padded).T.copy(),
        is_start,
        np.array([node for last in ends for node in last]),
        np.array([0, *accumulate(map(len, ends[:-1]))]),
    )


def _append(
    nodes: list[Node], word: Ways, before: Sequence[int], blank: int
) -> tuple[list[int], list[int]]:
    """Add a word after some nodes; returns its first and its last nodes."""
    firsts: list[int] = []
    lasts: list[int] = []
    for way in word:
        sources = before
        firsts.append(len(nodes))
        for place, symbol in enumerate(way):
            if place:
                nodes.append(Node(blank, [len(nodes) - 1, len(nodes)]))
                sources = [len(nodes) - 2, len(nodes) - 1]
            # A symbol that comes twice needs a blank between.
            others = [source for source in sources if nodes[source].symbol != symbol]
            nodes.append(Node(symbol, [*others, len(nodes)]))
        lasts.append(len(nodes) - 1)
    return firsts, lasts


def best_matches(relative: Floats, before: Floats, behind: Floats, sentences: Lattice) -> Matches:
    """Find where each sentence fits best.

    Args:
        relative: log-probabilities less that of the likeliest symbol, nats, moments x symbols.
        before: cost of beginning at each moment, nats.
        behind: cost of ending at each moment, nats.
        sentences: their lattice.
    """
    symbols, sources, starts, ends, firsts = sentences
    nodes, columns = len(symbols), np.arange(len(symbols))
    scores, begins = np.full(nodes + 1, -np.inf), np.zeros(nodes + 1, np.intp)
    found = Matches(np.full(len(firsts), -np.inf), *np.zeros((2, len(firsts)), np.intp))
    for moment, likely in enumerate(relative):
        likeliest = sources[scores[sources].argmax(axis=0), columns]
        reached, begun = scores[likeliest], begins[likeliest]
        entered = starts & (reached < -before[moment])
        scores[:nodes] = np.where(entered, -before[moment], reached) + likely[symbols]
        begins[:nodes] = np.where(entered, moment, begun)
        ended = np.maximum.reduceat(scores[ends], firsts) - behind[moment]
        for number in np.flatnonzero(ended > found.scores):
            last = slice(firsts[number], firsts[number + 1] if number + 1 < len(firsts) else None)
            found.scores[number], found.ends[number] = ended[number], moment
            found.begins[number] = begins[ends[last][scores[ends[last]].argmax()]]
    return found
