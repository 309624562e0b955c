"""Templates as states with words between them, joined to one automaton; pure.

Each is laid out by itself, with marks for its slots; joining finds the sentences that two have.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from voz.language.sentences.automaton import NO_LABEL, Arcs, Automaton, minimized
from voz.language.sentences.command_set import MarkedArc, SlotMarks, SlotReader
from voz.language.sentences.expression import (
    Choice,
    Concatenation,
    Expression,
    NumberRange,
    Optional,
    Permutation,
    ResolvedReference,
    Slot,
    Tag,
    Word,
    tagged_wordings,
)

MAX_TEMPLATE_ARCS = 1_000_000
"""Of one template; more take too much memory."""


class TooManyArcsError(Exception):
    """A template is too large."""


def lay_out(expression: Expression) -> SlotReader:
    """Turn an expression without references into states; raises TooManyArcsError."""
    states = _States()
    states.lay(expression, 0, 1)
    return states.without_silent()


class _States:
    """States with arcs by words, and arcs without words but with marks, removed at the end."""

    def __init__(self) -> None:
        self.words: list[list[tuple[str, int]]] = [[], []]
        self.silent: list[list[tuple[SlotMarks, int]]] = [[], []]
        self.arcs = 0

    def new(self) -> int:
        self.words.append([])
        self.silent.append([])
        return len(self.words) - 1

    def lay(self, item: Expression, start: int, end: int) -> None:
        """Lay an expression between two states; nothing leads back, so alternatives share them."""
        if isinstance(item, Word):
            self.words[start].append((item.text, end))
            self.arcs += 1
            if self.arcs > MAX_TEMPLATE_ARCS:
                raise TooManyArcsError
        elif isinstance(item, Concatenation):
            self._lay_in_order(item.items, start, end)
        elif isinstance(item, Choice):
            for one in item.items:
                self.lay(one, start, end)
        elif isinstance(item, Optional):
            self.lay(item.item, start, end)
            self.silent[start].append(((), end))
        elif isinstance(item, Permutation):
            self._lay_in_any_order(item.items, start, end)
        elif isinstance(item, NumberRange):
            self.lay(tagged_wordings(item), start, end)
        elif isinstance(item, Tag):
            self._lay_marked(item.item, (("<", ""),), ((">", item.value),), start, end)
        elif isinstance(item, Slot):
            self._lay_marked(item.item, (("{", item.name),), (("}", ""),), start, end)
        elif isinstance(item, ResolvedReference):
            self.lay(item.item, start, end)

    def _lay_in_order(self, items: Sequence[Expression], start: int, end: int) -> None:
        if not items:
            self.silent[start].append(((), end))
        for item in items[:-1]:
            after = self.new()
            self.lay(item, start, after)
            start = after
        if items:
            self.lay(items[-1], start, end)

    def _lay_in_any_order(self, items: Sequence[Expression], start: int, end: int) -> None:
        """Lay a state for each set of items that were said: there are fewer than orders."""
        everything = (1 << len(items)) - 1
        said = {0: start, everything: end}
        for done in range(everything):
            for number, item in enumerate(items):
                more = done | 1 << number
                if more != done:
                    if more not in said:
                        said[more] = self.new()
                    self.lay(item, said[done], said[more])

    def _lay_marked(
        self, item: Expression, begin: SlotMarks, close: SlotMarks, start: int, end: int
    ) -> None:
        first, last = self.new(), self.new()
        self.silent[start].append((begin, first))
        self.lay(item, first, last)
        self.silent[last].append((close, end))

    def without_silent(self) -> SlotReader:
        """Return the same automaton with words alone, each with the marks on the way to it."""
        number = {0: 0}
        todo, arcs, ends = [0], list[dict[str, list[MarkedArc]]](), dict[int, SlotMarks]()
        for state in todo:
            found: dict[str, list[MarkedArc]] = {}
            for near, marks in self._reached_silently(state):
                if near == 1:
                    ends[len(arcs)] = marks
                for word, target in self.words[near]:
                    if target not in number:
                        number[target] = len(todo)
                        todo.append(target)
                    targets = found.setdefault(word, [])
                    arc = (number[target], marks)
                    if arc not in targets:
                        targets.append(arc)
            arcs.append(found)
        return SlotReader(arcs, ends)

    def _reached_silently(self, state: int) -> Iterator[tuple[int, SlotMarks]]:
        """Return the states reached without a word, each by the first way."""
        seen: set[int] = set()
        todo: list[tuple[int, SlotMarks]] = [(state, ())]
        while todo:
            at, marks = todo.pop()
            if at not in seen:
                seen.add(at)
                yield at, marks
                todo += [(to, marks + more) for more, to in reversed(self.silent[at])]


MAX_JOINED_STATES = 300_000
"""Before minimization; more take minutes and gigabytes."""


@dataclass(frozen=True)
class SharedSentence:
    """An example of a sentence with two templates, or two readings of one."""

    sentence: str  # the example
    first: int  # the number of the template that comes first
    second: int  # that of the other, or the same


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
