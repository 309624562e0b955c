"""A template as states, to find the values of its slots in a sentence; pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import msgspec

from voz.language.sentences.expression import Value

SlotMark: TypeAlias = tuple[str, Value]
"""`{` and `}` are the ends of a slot, `<` and `>` those of a tag."""

SlotMarks: TypeAlias = tuple[SlotMark, ...]

MarkedArc: TypeAlias = tuple[int, SlotMarks]
"""The next state, and the marks before the word."""


class SlotReader(msgspec.Struct, frozen=True):
    """The states of a template, without cycles; it begins in the first.

    Attributes:
        arcs: of each state, by word.
        ends: the final states, and the marks at the end.
    """

    arcs: list[dict[str, list[MarkedArc]]]
    ends: dict[int, SlotMarks]

    def slots(self, words: Sequence[str]) -> dict[str, Value] | None:
        """The slots of a sentence, by its first reading; None if it is not of the template."""
        return next(self.readings(words), None)

    def readings(self, words: Sequence[str]) -> Iterator[dict[str, Value]]:
        """All readings of a sentence, perhaps some of them twice."""
        dead: set[tuple[int, int]] = set()
        for marks in self._paths(words, 0, 0, dead):
            yield _values(words, marks)

    def _paths(
        self, words: Sequence[str], at: int, state: int, dead: set[tuple[int, int]]
    ) -> Iterator[list[SlotMarks]]:
        """Yield the marks before each word from `at` on, and at the end."""
        if at == len(words):
            if state in self.ends:
                yield [self.ends[state]]
            return
        if (at, state) in dead:
            return
        found = False
        for target, marks in self.arcs[state].get(words[at], ()):
            for rest in self._paths(words, at + 1, target, dead):
                found = True
                yield [marks, *rest]
        if not found:
            dead.add((at, state))


def _values(words: Sequence[str], marks: Sequence[SlotMarks]) -> dict[str, Value]:
    found: dict[str, Value] = {}
    name, parts, tagged = "", list[Value](), 0
    for word, here in zip([*words, ""], marks, strict=True):
        for mark, value in here:
            if mark == "{":
                name, parts = str(value), []
            elif mark == "<":
                tagged = len(parts)
            elif mark == ">":
                parts[tagged:] = [value] if value != "" else []
            elif parts:
                found[name] = parts[0] if len(parts) == 1 else " ".join(map(str, parts))
                name = ""
        parts.append(word)
    return {name: value for name, value in found.items() if value != ""}
