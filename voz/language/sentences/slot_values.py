"""What else may be said in the slots of a sentence: for pages where it is chosen. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from voz.language.sentences.automaton import Automaton
from voz.language.sentences.command_set import Commands, SlotMarks, SlotReader
from voz.language.sentences.expression import Value

MAX_VALUES = 1200
"""Values of a slot that are found, each in a tenth of a millisecond."""

MAX_VALUE_WORDS = 8
"""Words of a value, such as `one hundred and twenty two point five`."""


@dataclass(frozen=True)
class SlotChoice:
    """A slot of a sentence, and what may be said there if the rest stays.

    Attributes:
        name: of the slot.
        start: its first word in the sentence, from 0.
        end: the word after it.
        values: each value by its words, in the order of the list.
    """

    name: str
    start: int
    end: int
    values: dict[str, Value]


def slot_choices(commands: Commands, text: str) -> list[SlotChoice]:
    """Return the slots of a sentence, in its order; none if it has none, or is no command."""
    words = text.split()
    label = commands.label(words)
    reader = None if label is None else commands.meanings[label].reader
    if label is None or reader is None:
        return []
    return [
        SlotChoice(name, start, end, _values(commands.automaton, reader, label, words, start, end))
        for name, start, end in _spans(next(reader.marks(words), []))
    ]


def _spans(marks: Sequence[SlotMarks]) -> Iterator[tuple[str, int, int]]:
    """Yield name, begin and end of each slot, by the marks before each word and at the end."""
    name, start = "", 0
    for at, here in enumerate(marks):
        for mark, value in here:
            if mark == "{":
                name, start = str(value), at
            elif mark == "}" and at > start:
                yield name, start, at


def _values(
    automaton: Automaton, reader: SlotReader, label: int, words: Sequence[str], start: int, end: int
) -> dict[str, Value]:
    before, after = list(words[:start]), list(words[end:])
    spans = [(name, at) for name, at, _ in _spans(next(reader.marks(words), []))]
    found: dict[str, Value] = {}
    for said in _continuations(automaton, automaton.walk(before), MAX_VALUE_WORDS):
        sentence = [*before, *said, *after]
        reached = automaton.walk(sentence)
        if reached is None or automaton.labels[reached] != label:
            continue
        longer = len(said) - (end - start)
        for marks in reader.marks(sentence):
            here = list(_spans(marks))
            moved = [(name, at + longer * (at > start)) for name, at in spans]
            if [(name, at) for name, at, _ in here] == moved and (
                any(at == start and to == start + len(said) for _, at, to in here)
            ):
                name = next(name for name, at, _ in here if at == start)
                found[" ".join(said)] = (reader.slots(sentence) or {}).get(name, " ".join(said))
                break
        if len(found) == MAX_VALUES:
            break
    return found


def _continuations(automaton: Automaton, state: int | None, most: int) -> Iterator[tuple[str, ...]]:
    """Yield the words to which a state leads, the fewest first."""
    level: list[tuple[int, tuple[str, ...]]] = [] if state is None else [(state, ())]
    for _ in range(most):
        level = [
            (to, (*words, word)) for at, words in level for word, to in automaton.arcs[at].items()
        ][: 10 * MAX_VALUES]
        yield from (words for _, words in level)
