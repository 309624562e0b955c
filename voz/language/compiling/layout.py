"""Turns a template into states with words between them and marks for its slots; pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

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
)
from voz.language.sentences.number_range import tagged_wordings
from voz.language.sentences.slot_reader import MarkedArc, SlotMarks, SlotReader

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
            self.lay(_number_words(item), start, end)
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


@lru_cache(maxsize=1000)
def _number_words(numbers: NumberRange) -> Expression:
    return tagged_wordings(numbers)
