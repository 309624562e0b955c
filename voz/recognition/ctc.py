"""Where in a sound each sentence fits best.

Viterbi through the lattice of connectionist temporal classification (Graves et al. 2006,
doi:10.1145/1143844.1143891), with a free beginning and end.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

Ways = Sequence[Sequence[int]]
"""All pronunciations of a word, as numbers of symbols."""

NO_WORD = -1
"""The word of a blank between words."""

NOWHERE = -1
"""Where a sentence comes from that begins."""


class Node(NamedTuple):
    """A symbol, the nodes from which it is reached, itself among them, and the word's index."""

    symbol: int
    sources: Sequence[int]
    word: int


class Lattice(NamedTuple):
    """Sentences side by side."""

    symbols: Places  # of each node
    sources: Places  # nodes that lead to each node, a column each, padded with their number
    starts: npt.NDArray[np.bool_]  # whether a sentence may begin at each node
    ends: Places  # nodes at which one may end, sentence by sentence
    firsts: Places  # where those of each sentence begin in `ends`
    words: Places  # of each node: the index of its word in the sentence, or `NO_WORD`


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
            firsts, last = _append(nodes, word, before, blank, place)
            if place == 0:
                starts += firsts
            if place < len(words) - 1:
                nodes.append(Node(blank, [*last, len(nodes)], NO_WORD))
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
        np.array([node.word for node in nodes]),
    )


def _append(
    nodes: list[Node], word: Ways, before: Sequence[int], blank: int, number: int
) -> tuple[list[int], list[int]]:
    """Add a word after some nodes; returns its first and its last nodes."""
    firsts: list[int] = []
    lasts: list[int] = []
    for way in word:
        sources = before
        firsts.append(len(nodes))
        for place, symbol in enumerate(way):
            if place:
                nodes.append(Node(blank, [len(nodes) - 1, len(nodes)], number))
                sources = [len(nodes) - 2, len(nodes) - 1]
            # A symbol that comes twice needs a blank between.
            others = [source for source in sources if nodes[source].symbol != symbol]
            nodes.append(Node(symbol, [*others, len(nodes)], number))
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
    ends, firsts = sentences.ends, sentences.firsts
    nodes = len(sentences.symbols)
    begins = np.zeros(nodes + 1, np.intp)
    found = Matches(np.full(len(firsts), -np.inf), *np.zeros((2, len(firsts)), np.intp))
    for moment, (scores, source, entered) in enumerate(_forward(relative, before, sentences)):
        begins[:nodes] = np.where(entered, moment, begins[source])
        ended = np.maximum.reduceat(scores[ends], firsts) - behind[moment]
        for number in np.flatnonzero(ended > found.scores):
            last = slice(firsts[number], firsts[number + 1] if number + 1 < len(firsts) else None)
            found.scores[number], found.ends[number] = ended[number], moment
            found.begins[number] = begins[ends[last][scores[ends[last]].argmax()]]
    return found


class Path(NamedTuple):
    """Where a sentence fits best.

    Attributes:
        score: its relative log-likelihood, nats.
        begin: its first moment.
        nodes: the node of its lattice at each moment from then on; none if it fits nowhere.
    """

    score: float
    begin: int
    nodes: list[int]


def best_path(relative: Floats, before: Floats, behind: Floats, sentence: Lattice) -> Path:
    """Find the way through a sentence where it fits best.

    Args:
        relative: as for `best_matches`, like the next two.
        before: cost of beginning at each moment, nats.
        behind: cost of ending at each moment, nats.
        sentence: a lattice of one.
    """
    best, moment, node = -np.inf, 0, NOWHERE
    came: list[Places] = []
    for now, (scores, source, entered) in enumerate(_forward(relative, before, sentence)):
        came.append(np.where(entered, NOWHERE, source))
        last = sentence.ends[scores[sentence.ends].argmax()]
        if scores[last] - behind[now] > best:
            best, moment, node = float(scores[last] - behind[now]), now, int(last)
    nodes: list[int] = []
    while node != NOWHERE:
        nodes.append(node)
        node = int(came[moment][node])
        moment -= 1
    return Path(best, moment + 1, nodes[::-1])


def align(
    relative: Floats, before: Floats, behind: Floats, sentence: Lattice
) -> list[tuple[int, int]]:
    """Find the first and last moment of each word of a sentence where it fits best.

    The arguments are those of `best_path`; the sentence must fit somewhere.
    """
    path = best_path(relative, before, behind, sentence)
    places: dict[int, tuple[int, int]] = {}
    for moment, node in enumerate(path.nodes, path.begin):
        word = int(sentence.words[node])
        places[word] = places.get(word, (moment, moment))[0], moment
    return [places[word] for word in sorted(places.keys() - {NO_WORD})]


def _forward(
    relative: Floats, before: Floats, sentences: Lattice
) -> Iterator[tuple[Floats, Places, npt.NDArray[np.bool_]]]:
    """At each moment each node's best score, the node before it, and whether it begins there."""
    symbols, sources, starts = sentences.symbols, sentences.sources, sentences.starts
    nodes, columns = len(symbols), np.arange(len(symbols))
    scores = np.full(nodes + 1, -np.inf)
    for cost, likely in zip(before, relative, strict=True):
        source = sources[scores[sources].argmax(axis=0), columns]
        reached = scores[source]
        entered = starts & (reached < -cost)
        scores[:nodes] = np.where(entered, -cost, reached) + likely[symbols]
        yield scores, source, entered
