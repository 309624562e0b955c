"""All sentences as an automaton: states with words between them; pure.

It is minimal and acyclic: a few hundred states hold millions of sentences, which can be counted,
and each of which can be found by its number.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property

NO_LABEL = -1
"""The label of a state in which no sentence ends."""

Arcs = list[dict[str, int]]
"""For each state the next state by word."""


class Automaton:
    """Sentences, each with a label."""

    def __init__(self, arcs: Arcs, labels: list[int]) -> None:
        """Take states without cycles, each of which leads to an end."""
        # For each state the next state by word; every sentence begins in the first.
        self.arcs = arcs
        self.labels = labels  # of the sentences that end in each state, or `NO_LABEL`

    @cached_property
    def counts(self) -> list[int]:
        """Sentences that continue from each state."""
        counts = [0] * len(self.arcs)
        for state in bottom_up(self.arcs):
            ends = self.labels[state] != NO_LABEL
            counts[state] = ends + sum(counts[to] for to in self.arcs[state].values())
        return counts

    @property
    def count(self) -> int:
        """Number of sentences."""
        return self.counts[0]

    @cached_property
    def longest(self) -> int:
        """Words of the longest sentence."""
        depths = [0] * len(self.arcs)
        for state in bottom_up(self.arcs):
            depths[state] = max((1 + depths[to] for to in self.arcs[state].values()), default=0)
        return depths[0]

    @cached_property
    def words(self) -> tuple[str, ...]:
        """All words, each once."""
        return tuple(dict.fromkeys(word for arcs in self.arcs for word in arcs))

    def walk(self, words: Iterable[str], state: int = 0) -> int | None:
        """Return the state after these words; None if no sentence begins so."""
        for word in words:
            following = self.arcs[state].get(word)
            if following is None:
                return None
            state = following
        return state

    def sentence(self, number: int) -> str:
        """Return the sentence with a number, from 0."""
        words, state = list[str](), 0
        while True:
            if self.labels[state] != NO_LABEL:
                if number == 0:
                    return " ".join(words)
                number -= 1
            for word, to in self.arcs[state].items():
                if number < self.counts[to]:
                    words.append(word)
                    state = to
                    break
                number -= self.counts[to]

    def sample(self, number: int, seed: int = 0) -> list[str]:
        """Draw at most `number` different sentences, each equally likely."""
        drawn = random.Random(seed).sample(range(self.count), min(number, self.count))
        return [self.sentence(one) for one in drawn]

    def sentences(self) -> list[str]:
        """Return all sentences in the order of their labels; there must not be too many."""
        return [text for _, text in sorted(self._labeled(0, []), key=lambda pair: pair[0])]

    def sentences_with_words(self, words: Collection[str]) -> list[str]:
        """Return a sentence for each of some words."""
        way = {0: ""}
        found: dict[str, str] = {}
        for state in reversed(bottom_up(self.arcs)):
            for word, to in self.arcs[state].items():
                way.setdefault(to, f"{way[state]} {word}")
                if word in words and word not in found:
                    found[word] = f"{way[state]} {word} {self._shortest(to)}".strip()
        return list(found.values())

    def continuations(self, state: int) -> list[str]:
        """Return a short end of a sentence for each word that may follow in a state."""
        ends = ((word, self._shortest(to)) for word, to in self.arcs[state].items())
        return [f"{word} {rest}".strip() for word, rest in ends]

    def _shortest(self, state: int) -> str:
        words = list[str]()
        while self.labels[state] == NO_LABEL:
            word, state = next(iter(self.arcs[state].items()))
            words.append(word)
        return " ".join(words)

    def _labeled(self, state: int, before: list[str]) -> Iterator[tuple[int, str]]:
        if self.labels[state] != NO_LABEL:
            yield self.labels[state], " ".join(before)
        for word, to in self.arcs[state].items():
            yield from self._labeled(to, [*before, word])

    def sentences_with_label(self, label: int, most: int) -> list[str]:
        """Return the shortest sentences with a label."""
        found: list[str] = []
        level: list[tuple[int, tuple[str, ...]]] = [(0, ())]
        while level and len(found) < most:
            found += [" ".join(words) for state, words in level if self.labels[state] == label]
            level = [
                (to, (*words, word))
                for state, words in level
                for word, to in self.arcs[state].items()
                if label in self._reachable_labels[to]
            ][:most]
        return found[:most]

    @cached_property
    def _reachable_labels(self) -> list[frozenset[int]]:
        """List the labels of the sentences that continue from each state."""
        found = [frozenset[int]()] * len(self.arcs)
        for state in bottom_up(self.arcs):
            own = {self.labels[state]} - {NO_LABEL}
            found[state] = frozenset(own).union(*(found[to] for to in self.arcs[state].values()))
        return found

    @cached_property
    def counts_by_label(self) -> Mapping[int, int]:
        """Number of sentences by label."""
        ways, found = [0] * len(self.arcs), dict[int, int]()
        ways[0] = 1
        for state in reversed(bottom_up(self.arcs)):
            if (label := self.labels[state]) != NO_LABEL:
                found[label] = found.get(label, 0) + ways[state]
            for to in self.arcs[state].values():
                ways[to] += ways[state]
        return found


def prefix_tree(sentences: Sequence[str]) -> Automaton:
    """Make an automaton of a list; the label of a sentence is its place in the list."""
    arcs: Arcs = [{}]
    labels = [NO_LABEL]
    for number, sentence in enumerate(sentences):
        state = 0
        for word in sentence.split():
            following = arcs[state].get(word)
            if following is None:
                following = arcs[state][word] = len(arcs)
                arcs.append({})
                labels.append(NO_LABEL)
            state = following
        if labels[state] == NO_LABEL:
            labels[state] = number
    return Automaton(arcs, labels)


def bottom_up(arcs: Arcs) -> list[int]:
    """Return all reachable states, each after the states that it leads to."""
    order, seen = list[int](), {0}
    path = [(0, iter(arcs[0].values()))]
    while path:
        state, following = path[-1]
        for to in following:
            if to not in seen:
                seen.add(to)
                path.append((to, iter(arcs[to].values())))
                break
        else:
            order.append(state)
            path.pop()
    return order


def minimized(arcs: Arcs, labels: list[int]) -> Automaton:
    """Merge equivalent states and drop unreachable ones."""
    merged: dict[int, int] = {}
    known: dict[tuple[object, ...], int] = {}
    kept: list[int] = []
    for state in bottom_up(arcs):
        following = {word: merged[to] for word, to in arcs[state].items()}
        same = (labels[state], *sorted(following.items()))
        if same not in known:
            known[same] = len(kept)
            kept.append(state)
        merged[state] = known[same]
    last = len(kept) - 1  # the first state comes last, and becomes the first again
    final: Arcs = [
        {word: last - merged[to] for word, to in arcs[state].items()} for state in reversed(kept)
    ]
    return Automaton(final, [labels[state] for state in reversed(kept)])
