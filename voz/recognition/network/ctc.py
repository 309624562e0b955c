"""Where in a sound each sentence fits best, and which of millions fits best.

Viterbi through the lattice of connectionist temporal classification (Graves et al. 2006,
doi:10.1145/1143844.1143891), with a free beginning and end. A list that is too long for a lattice
is an automaton, searched with tokens through all words between its states (Young, Russell and
Thornton 1989, "Token Passing"): a token is the moment at which the word before ended, so that the
words can be read backward at the end.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import accumulate, groupby
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from voz.language.sentences.automaton import NO_LABEL, Automaton

Floats = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

Pronunciations = Sequence[Sequence[int]]
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


def lattice(sentences: Iterable[Sequence[Pronunciations]], blank: int) -> Lattice:
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
    nodes: list[Node], word: Pronunciations, before: Sequence[int], blank: int, number: int
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
            # A symbol that comes twice in a word needs a blank between; where a word ends as the
            # next begins, as in "left turn", people say it once.
            others = [node for node in sources if not place or nodes[node].symbol != symbol]
            nodes.append(Node(symbol, [*others, len(nodes)], number))
        lasts.append(len(nodes) - 1)
    return firsts, lasts


def best_matches(log_ratios: Floats, before: Floats, behind: Floats, sentences: Lattice) -> Matches:
    """Find where each sentence fits best.

    Args:
        log_ratios: log-probabilities less that of the likeliest symbol, nats, moments x symbols.
        before: cost of beginning at each moment, nats.
        behind: cost of ending at each moment, nats.
        sentences: their lattice.
    """
    ends, firsts = sentences.ends, sentences.firsts
    nodes = len(sentences.symbols)
    begins = np.zeros(nodes + 1, np.intp)
    found = Matches(np.full(len(firsts), -np.inf), *np.zeros((2, len(firsts)), np.intp))
    for moment, (scores, source, entered) in enumerate(_forward(log_ratios, before, sentences)):
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


def best_path(log_ratios: Floats, before: Floats, behind: Floats, sentence: Lattice) -> Path:
    """Find the way through a sentence where it fits best.

    Args:
        log_ratios: as for `best_matches`, like the next two.
        before: cost of beginning at each moment, nats.
        behind: cost of ending at each moment, nats.
        sentence: a lattice of one.
    """
    best, moment, node = -np.inf, 0, NOWHERE
    came: list[Places] = []
    for now, (scores, source, entered) in enumerate(_forward(log_ratios, before, sentence)):
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
    log_ratios: Floats, before: Floats, behind: Floats, sentence: Lattice
) -> list[tuple[int, int]]:
    """Find the first and last moment of each word of a sentence where it fits best.

    The arguments are those of `best_path`; the sentence must fit somewhere.
    """
    path = best_path(log_ratios, before, behind, sentence)
    places: dict[int, tuple[int, int]] = {}
    for moment, node in enumerate(path.nodes, path.begin):
        word = int(sentence.words[node])
        places[word] = places.get(word, (moment, moment))[0], moment
    return [places[word] for word in sorted(places.keys() - {NO_WORD})]


def longest_gap(log_ratios: Floats, before: Floats, behind: Floats, sentence: Lattice) -> int:
    """The most moments in a row that have no phone within a word, where a sentence fits best.

    The arguments are those of `best_path`.
    """
    blank = log_ratios.shape[1] - 1
    path = best_path(log_ratios, before, behind, sentence)
    in_gap = [sentence.symbols[n] == blank and sentence.words[n] != NO_WORD for n in path.nodes]
    return max((len([*same]) for is_gap, same in groupby(in_gap) if is_gap), default=0)


def _forward(
    log_ratios: Floats, before: Floats, sentences: Lattice
) -> Iterator[tuple[Floats, Places, npt.NDArray[np.bool_]]]:
    """At each moment each node's best score, the node before it, and whether it begins there."""
    symbols, sources, starts = sentences.symbols, sentences.sources, sentences.starts
    nodes, columns = len(symbols), np.arange(len(symbols))
    scores = np.full(nodes + 1, -np.inf)
    for cost, likely in zip(before, log_ratios, strict=True):
        source = sources[scores[sources].argmax(axis=0), columns]
        reached = scores[source]
        entered = starts & (reached < -cost)
        scores[:nodes] = np.where(entered, -cost, reached) + likely[symbols]
        yield scores, source, entered


NEVER = -1
"""The token of a word that begins a sentence."""


class _Word(NamedTuple):
    """One pronunciation of a word between two states."""

    start: int
    end: int
    text: str
    phones: tuple[int, ...]


class SentenceSearch:
    """Searches all sentences of an automaton at once."""

    def __init__(
        self, automaton: Automaton, ways: Mapping[str, Pronunciations], blank: int, reward: float
    ) -> None:
        """Lay out the words.

        Args:
            automaton: the sentences, at least one.
            ways: the pronunciations of each word, as numbers of symbols.
            blank: number of the symbol between phones.
            reward: for each phone, nats.
        """
        self._words = sorted(
            (
                _Word(state, to, word, tuple(way))
                for state, arcs in enumerate(automaton.arcs)
                for word, to in arcs.items()
                for way in ways[word]
            ),
            key=lambda word: word.end,
        )
        self._arcs = automaton.arcs
        self._blank, self._reward = blank, reward
        self._states = len(automaton.arcs)
        self._symbols = np.array([phone for word in self._words for phone in word.phones])
        self._lasts = np.cumsum([len(word.phones) for word in self._words]) - 1
        ends = np.array([word.end for word in self._words])
        # Every state but the first is the end of a word.
        self._first_ways = np.searchsorted(ends, np.arange(1, self._states))
        self._labels = np.array(automaton.labels)[ends]
        self.final = np.flatnonzero(self._labels != NO_LABEL)
        self._direct, self._by_blank = self._sources()

    def _sources(self) -> tuple[Places, Places]:
        """Where each phone, and the blank before it, comes from: a phone, a state or nowhere."""
        phones = len(self._symbols)
        nowhere = phones + self._states
        direct = np.arange(phones) - 1
        by_blank = direct.copy()
        # A symbol that comes twice needs a blank between.
        direct[1:][self._symbols[1:] == self._symbols[:-1]] = nowhere
        firsts = self._lasts - [len(word.phones) - 1 for word in self._words]
        direct[firsts] = phones + np.array([word.start for word in self._words])
        by_blank[firsts] = nowhere
        return direct, by_blank

    def search(self, log_ratios: Floats, before: Floats, behind: Floats) -> FoundSentences:
        """Search a sound; arguments are those of `best_matches`."""
        return FoundSentences(self, *self._forward(log_ratios, before), behind)

    def _forward(self, log_ratios: Floats, before: Floats) -> tuple[Floats, Places]:
        """The score and the token of each word that ends at each moment."""
        phones, states = len(self._symbols), self._states
        # Phones, then states, then nowhere.
        score = np.full(phones + states + 1, -np.inf)
        token = np.full(phones + states + 1, NEVER, np.intp)
        blank, blank_token = np.full(phones, -np.inf), np.full(phones, NEVER, np.intp)
        pause, pause_token = np.full(states, -np.inf), np.full(states, NEVER, np.intp)
        scores = np.empty((len(log_ratios), len(self._words)))
        tokens = np.empty((len(log_ratios), len(self._words)), np.intp)
        for moment, likely in enumerate(log_ratios):
            word_ends = np.maximum.reduceat(score[self._lasts], self._first_ways)
            after_pause = pause[1:] > word_ends
            state, state_token = score[phones:-1], token[phones:-1]
            state[0] = -before[moment]
            state[1:] = np.maximum(word_ends, pause[1:])
            state_token[1:] = np.where(after_pause, pause_token[1:], moment - 1)
            pause[1:] = state[1:] + likely[self._blank]
            pause_token[:] = state_token
            came, came_token = score[self._direct] + self._reward, token[self._direct]
            through, through_token = blank + self._reward, blank_token
            into_blank = score[self._by_blank]
            newer = into_blank > blank
            stayed, stayed_token = score[:phones], token[:phones]
            best = np.maximum(stayed, np.maximum(came, through))
            best_token = np.where(
                best == stayed, stayed_token, np.where(best == came, came_token, through_token)
            )
            blank = np.maximum(into_blank, blank) + likely[self._blank]
            blank_token = np.where(newer, token[self._by_blank], blank_token)
            score[:phones] = best + likely[self._symbols]
            token[:phones] = best_token
            scores[moment], tokens[moment] = score[self._lasts], token[self._lasts]
        return scores, tokens

    def read_backward(self, scores: Floats, tokens: Places, moment: int, last: int) -> str:
        """The words that end with a word at a moment."""
        words = [self._words[last].text]
        while (state := self._words[last].start) != 0:
            moment, ways = int(tokens[moment, last]), self._ways_into(state)
            last = ways.start + int(scores[moment, ways].argmax())
            words.append(self._words[last].text)
        return " ".join(reversed(words))

    def ends_of(self, label: int) -> Places:
        """The words with which the sentences of a label end."""
        return np.flatnonzero(self._labels == label)

    def words_beside(self, sentence: str, *, itself: bool = False) -> Places:
        """The words that lead to a state through which a sentence does not go.

        With `itself` those that lead to any state but its last.
        """
        through = [0]
        for word in sentence.split():
            through.append(self._arcs[through[-1]][word])
        ends = np.array([word.end for word in self._words])
        return np.flatnonzero(~np.isin(ends, through[-1:] if itself else through))

    def _ways_into(self, state: int) -> slice:
        following = [*self._first_ways[state:], len(self._words)]
        return slice(int(self._first_ways[state - 1]), int(following[0]))


class FoundSentences:
    """What a search has found in a sound."""

    def __init__(
        self, search: SentenceSearch, scores: Floats, tokens: Places, behind: Floats
    ) -> None:
        """Take the score and the token of each word that ends at each moment."""
        self._search, self._scores, self._tokens, self._behind = search, scores, tokens, behind

    @property
    def best(self) -> str:
        """The sentence that fits best; empty if the sound has fewer moments than any has phones."""
        return self._best_of(self._search.final)[0]

    def best_begun(self, sentence: str, *, itself: bool = False) -> tuple[str, float]:
        """The words that fit best of all with which another sentence begins, and their score.

        Not those after which that one and this go on alike, unless with `itself`: then these
        words may begin this one, too.
        """
        return self._best_of(self._search.words_beside(sentence, itself=itself))

    def best_score(self, label: int) -> float:
        """The score of the best sentence of a label, nats."""
        ended = self._scores[:, self._search.ends_of(label)] - self._behind[:, np.newaxis]
        return float(ended.max(initial=-np.inf))

    def _best_of(self, words: Places) -> tuple[str, float]:
        ended = self._scores[:, words] - self._behind[:, np.newaxis]
        if not ended.size:
            return "", -np.inf
        moment, word = np.unravel_index(ended.argmax(), ended.shape)
        score = float(ended[moment, word])
        if score == -np.inf:
            return "", score
        last = int(words[word])
        return self._search.read_backward(self._scores, self._tokens, int(moment), last), score
