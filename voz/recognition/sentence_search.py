"""The sentence of an automaton that fits a sound best, of millions, by the phoneme network.

Viterbi with tokens through all words between the states (Young, Russell and Thornton 1989, "Token
Passing"): a token is the moment at which the word before ended, so that the words can be read
backward at the end.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from voz.language.sentences.automaton import NO_LABEL, Automaton
from voz.recognition.ctc import Floats, Places, Ways

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
        self, automaton: Automaton, ways: Mapping[str, Ways], blank: int, reward: float
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
        self.final = np.flatnonzero(np.array(automaton.labels)[ends] != NO_LABEL)
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

    def search(self, relative: Floats, before: Floats, behind: Floats) -> FoundSentences:
        """Search a sound; arguments are those of `ctc.best_matches`."""
        return FoundSentences(self, *self._forward(relative, before), behind)

    def _forward(self, relative: Floats, before: Floats) -> tuple[Floats, Places]:
        """The score and the token of each word that ends at each moment."""
        phones, states = len(self._symbols), self._states
        # Phones, then states, then nowhere.
        score = np.full(phones + states + 1, -np.inf)
        token = np.full(phones + states + 1, NEVER, np.intp)
        blank, blank_token = np.full(phones, -np.inf), np.full(phones, NEVER, np.intp)
        pause, pause_token = np.full(states, -np.inf), np.full(states, NEVER, np.intp)
        scores = np.empty((len(relative), len(self._words)))
        tokens = np.empty((len(relative), len(self._words)), np.intp)
        for moment, likely in enumerate(relative):
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

    def words_beside(self, sentence: str) -> Places:
        """The words that lead to a state through which a sentence does not go."""
        through = [0]
        for word in sentence.split():
            through.append(self._arcs[through[-1]][word])
        ends = np.array([word.end for word in self._words])
        return np.flatnonzero(~np.isin(ends, through))

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

    def best_begun(self, sentence: str) -> tuple[str, float]:
        """The words that fit best of all with which another sentence begins, and their score.

        Not those after which that one and this go on alike.
        """
        return self._best_of(self._search.words_beside(sentence))

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
