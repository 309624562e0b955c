"""How likely sentences are, by a network that tells one symbol or none each moment.

Connectionist temporal classification, Graves et al. 2006 (doi:10.1145/1143844.1143891): the
probabilities of all ways to spread a sentence over the moments add up, and so do those of all ways
to pronounce its words. Pure.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

Ways = Sequence[Sequence[int]]
"""The symbols of a word, by number, in all the ways that it may be pronounced."""

TINY = 1e-300
"""Of a sentence that does not fit into the moments; its logarithm is still a number."""


class Node(NamedTuple):
    """A symbol of a sentence, or the blank between two.

    Attributes:
        symbol: its number.
        before: the nodes from which it is reached, itself among them.
    """

    symbol: int
    before: Sequence[int]


class Lattice(NamedTuple):
    """Sentences laid side by side, to be followed together.

    Attributes:
        symbols: of each node.
        sources: the nodes from which each node is reached, one node after the other.
        reached: where those of each node begin in that.
        firsts: the first node of each sentence.
        sizes: how many nodes each sentence has.
        starts: 1 for nodes at which a sentence may begin, else 0.
        ends: 1 for nodes at which one may end.
    """

    symbols: Places
    sources: Places
    reached: Places
    firsts: Places
    sizes: Places
    starts: Floats
    ends: Floats


def lattice(sentences: Iterable[Sequence[Ways]], blank: int) -> Lattice:
    """Lay sentences side by side.

    Args:
        sentences: their words, at least one each; no way to pronounce one is empty.
        blank: the number of the blank.
    """
    nodes: list[Node] = []
    firsts, starts, ends = [], [], []
    for words in sentences:
        firsts.append(len(nodes))
        nodes.append(Node(blank, [len(nodes)]))
        last = [firsts[-1]]
        for word in words:
            last = _append(nodes, word, last, blank)
        starts += [n for n in range(firsts[-1], len(nodes)) if firsts[-1] in nodes[n].before]
        ends += last
    counts = [len(node.before) for node in nodes]
    return Lattice(
        np.array([node.symbol for node in nodes]),
        np.array([source for node in nodes for source in node.before]),
        np.cumsum([0, *counts[:-1]]),
        np.array(firsts),
        np.diff([*firsts, len(nodes)]),
        _marked(starts, len(nodes)),
        _marked(ends, len(nodes)),
    )


def _append(nodes: list[Node], word: Ways, last: Sequence[int], blank: int) -> list[int]:
    """Lay a word behind the last nodes of the one before it; gives its own last ones."""
    ends: list[int] = []
    for way in word:
        before = last
        for place, symbol in enumerate(way):
            if place:
                nodes.append(Node(blank, [before[0], len(nodes)]))
                before = [*before, len(nodes) - 1]
            # One that is said twice needs a blank between.
            others = [n for n in before if nodes[n].symbol != symbol]
            nodes.append(Node(symbol, [*others, len(nodes)]))
            before = [len(nodes) - 1]
        ends += before
    nodes.append(Node(blank, [*ends, len(nodes)]))
    return [*ends, len(nodes) - 1]


def _marked(places: Sequence[int], size: int) -> Floats:
    marks = np.zeros(size)
    marks[list(places)] = 1
    return marks


def log_likelihoods(probabilities: Floats, sentences: Lattice) -> Floats:
    """Tell how likely each sentence is.

    Args:
        probabilities: moments x symbols.
        sentences: as `lattice` lays them.

    Returns:
        A natural logarithm for each.
    """
    forward = sentences.starts * probabilities[0, sentences.symbols]
    total = np.zeros(len(sentences.firsts))
    for moment in probabilities[1:]:
        scale = np.add.reduceat(forward, sentences.firsts) + TINY  # else they become too small
        total += np.log(scale)
        forward /= np.repeat(scale, sentences.sizes)
        forward = np.add.reduceat(forward[sentences.sources], sentences.reached)
        forward *= moment[sentences.symbols]
    ended = np.add.reduceat(forward * sentences.ends, sentences.firsts)
    found: Floats = total + np.log(np.maximum(ended, TINY))
    return found
