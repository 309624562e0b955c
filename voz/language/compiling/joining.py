"""Joins templates to one automaton, and finds sentences that two of them have; pure."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from voz.language.sentences.automaton import NO_LABEL, Arcs, Automaton, minimized
from voz.language.sentences.slot_reader import SlotReader

MAX_JOINED_STATES = 300_000
"""Before minimization; more take minutes and gigabytes."""


@dataclass(frozen=True)
class SharedSentence:
    """An example of a sentence with two templates, or two readings of one.

    Attributes:
        sentence: the example.
        first: the number of the template that comes first.
        second: that of the other, or the same.
    """

    sentence: str
    first: int
    second: int


class TooManyStatesError(Exception):
    """The templates together are too many."""


def join_readers(readers: Sequence[SlotReader]) -> tuple[Automaton, list[SharedSentence]]:
    """Make one automaton of templates by the subset construction; label it by their numbers.

    A sentence of several belongs to the first; those are returned too. Raises TooManyStatesError.
    """
    joining = _Joining(readers)
    joining.join()
    return minimized(joining.arcs, joining.labels), list(joining.shared.values())


class _Joining:
    def __init__(self, readers: Sequence[SlotReader]) -> None:
        self.begins: list[int] = []
        self.steps: list[dict[str, list[int]]] = []
        self.ends: dict[int, int] = {}
        for number, reader in enumerate(readers):
            begin = len(self.steps)
            self.begins.append(begin)
            self.ends.update(dict.fromkeys((begin + end for end in reader.ends), number))
            self.steps += (
                {word: [begin + to for to, _ in found] for word, found in arcs.items()}
                for arcs in reader.arcs
            )
        self.arcs: Arcs = []
        self.labels: list[int] = []
        self.shared: dict[tuple[int, int], SharedSentence] = {}
        self._numbers: dict[tuple[int, ...], int] = {}
        self._todo: list[tuple[int, ...]] = []
        self._before: list[tuple[int, str]] = []  # one way to each state

    def join(self) -> None:
        self._number(tuple(self.begins), (NO_LABEL, ""))
        for state, members in enumerate(self._todo):
            self._label_state(state, [member for member in members if member in self.ends])
            following: dict[str, list[int]] = {}
            for member in members:
                for word, targets in self.steps[member].items():
                    following.setdefault(word, []).extend(targets)
            arcs = {}
            for word, targets in following.items():
                apart = tuple(targets) if len(targets) == 1 else tuple(sorted(set(targets)))
                arcs[word] = self._number(apart, (state, word))
                if len(apart) < len(targets):
                    twice = next(to for to in apart if targets.count(to) > 1)
                    template = bisect_right(self.begins, twice) - 1
                    self._note_shared(arcs[word], twice, (template, template))
            self.arcs.append(arcs)

    def _number(self, members: tuple[int, ...], before: tuple[int, str]) -> int:
        known = self._numbers.get(members)
        if known is None:
            if len(self._todo) == MAX_JOINED_STATES:
                raise TooManyStatesError
            known = self._numbers[members] = len(self._todo)
            self._todo.append(members)
            self._before.append(before)
        return known

    def _label_state(self, state: int, ended: Sequence[int]) -> None:
        labels = sorted(self.ends[member] for member in ended)
        self.labels.append(labels[0] if labels else NO_LABEL)
        for other in labels[1:]:
            self._note_shared(state, ended[0], (labels[0], other))

    def _note_shared(self, state: int, member: int, templates: tuple[int, int]) -> None:
        if templates not in self.shared:
            sentence = " ".join([*self._words_to(state), *self._words_after(member)])
            self.shared[templates] = SharedSentence(sentence, *templates)

    def _words_to(self, state: int) -> list[str]:
        words = []
        while state:
            state, word = self._before[state]
            words.append(word)
        return words[::-1]

    def _words_after(self, member: int) -> list[str]:
        words = []
        while member not in self.ends:
            word, targets = next(iter(self.steps[member].items()))
            words.append(word)
            member = targets[0]
        return words
