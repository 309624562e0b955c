"""The commands of a language, from plain lists and templates alike; pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from typing import TypeAlias

import msgspec

from voz.errors import LanguageError
from voz.language.sentences.automaton import NO_LABEL, Automaton, prefix_tree
from voz.language.sentences.expression import Value
from voz.language.sentences.neighbors import LetterDistances, WordCosts, nearest
from voz.language.sentences.spelling import (
    ENGLISH,
    first_wording,
    normalize,
    plain_form,
    spoken_forms,
    strip_accents,
)

SlotMark: TypeAlias = tuple[str, Value]
"""`{` and `}` are the ends of a slot, `<` and `>` those of a tag."""

SlotMarks: TypeAlias = tuple[SlotMark, ...]

MarkedArc: TypeAlias = tuple[int, SlotMarks]
"""The next state, and the marks before the word."""


class SlotReader(msgspec.Struct, frozen=True):
    """The states of a template, without cycles; it begins in the first."""

    arcs: list[dict[str, list[MarkedArc]]]  # of each state, by word
    ends: dict[int, SlotMarks]  # the final states, and the marks at the end

    def slots(self, words: Sequence[str]) -> dict[str, Value] | None:
        """The slots of a sentence, by its first reading; None if it is not of the template."""
        return next(self.readings(words), None)

    def marks(self, words: Sequence[str]) -> Iterator[list[SlotMarks]]:
        """Yield the marks before each word and at the end, of all readings."""
        yield from self._paths(words, 0, 0, set())

    def readings(self, words: Sequence[str]) -> Iterator[dict[str, Value]]:
        """All readings of a sentence, perhaps some of them twice."""
        for marks in self.marks(words):
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


MAX_LISTED_SENTENCES = 5_000
"""Sentences of templates that are listed one by one; of more some are drawn."""

MAX_EXAMPLES = 500
"""Sentences of a template of which the shortest is its example."""

MAX_WRONG_LETTERS = 0.4
"""Share of letters that may be wrong to guess which sentence was meant."""


class Meaning(msgspec.Struct, frozen=True, omit_defaults=True):
    """What the sentences of a template mean."""

    command: str  # its name
    constants: dict[str, Value] = {}  # slots that are always the same
    reader: SlotReader | None = None  # finds the others; None if there are none
    template: int = 0  # the number of the template, which gives several commands if it has no name


@dataclass(frozen=True)
class Parse:
    """What a sentence means."""

    text: str  # the sentence in words, as it is spoken
    command: str  # the name of its template
    slots: Mapping[str, Value] = field(default_factory=dict)  # their values by name

    def is_one_of(self, names: Collection[str]) -> bool:
        """Whether the sentence or its command is among some names."""
        return self.text in names or self.command in names


class Commands(Collection[str]):
    """All sentences of a language, however many, and what each means."""

    def __init__(
        self, automaton: Automaton, meanings: Sequence[Meaning], language: str = ENGLISH
    ) -> None:
        """Combine an automaton with the meanings of its labels."""
        self.automaton = automaton  # the sentences, labeled by places in `meanings`
        self.meanings = meanings  # of each template, or of each sentence of a plain list
        self.language = language  # in which typed numbers are said

    def __len__(self) -> int:
        return self.automaton.count

    def __iter__(self) -> Iterator[str]:
        return iter(self.listed)

    def __contains__(self, text: object) -> bool:
        return isinstance(text, str) and self.label(text.split()) is not None

    @property
    def can_be_listed(self) -> bool:
        """Whether there are few enough to list; every plain list can be."""
        return len(self) <= max(MAX_LISTED_SENTENCES, len(self.meanings))

    @cached_property
    def listed(self) -> list[str]:
        """All sentences in the order of the list; raises LanguageError if they are too many."""
        if not self.can_be_listed:
            raise LanguageError(
                f"{len(self):,} sentences are too many to list; "
                f"use templates of at most {MAX_LISTED_SENTENCES:,}"
            )
        return self.automaton.sentences()

    @cached_property
    def have_slots(self) -> bool:
        """Whether any sentence has slots."""
        return any(meaning.constants or meaning.reader for meaning in self.meanings)

    @property
    def longest(self) -> int:
        """Words of the longest sentence."""
        return self.automaton.longest

    @property
    def vocabulary(self) -> tuple[str, ...]:
        """All words, each once."""
        return self.automaton.words

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The commands, each once, in the order of the list."""
        return tuple(dict.fromkeys(meaning.command for meaning in self.meanings))

    @cached_property
    def examples_by_name(self) -> dict[str, str]:
        """The shortest sentence of each command, in the order of the list."""
        found: dict[str, str] = {}
        for label, meaning in enumerate(self.meanings):
            if meaning.command not in found and (example := self.example(label)):
                found[meaning.command] = example
        return found

    def example(self, label: int) -> str | None:
        """Return a short sentence of a label; None if those before it have all of them."""
        name = self.meanings[label].command
        if self.label(name.split()) == label:  # as in a plain list, which may be very long
            return name
        some = self.automaton.sentences_with_label(label, MAX_EXAMPLES)
        return min(some, key=lambda text: len(text.split()), default=None)

    def find_name(self, name: str) -> str | None:
        """Find the command that a name is, perhaps with other capitals, spaces or no accents."""
        if name in self._names:
            return name
        found = self._plain_names.get(plain_form(name), [])
        exact = [each for each in found if len(found) == 1 or each == normalize(name)]
        return exact[0] if exact else None

    @cached_property
    def alternatives(self) -> list[tuple[str, ...]]:
        """The commands of each template that gives several, in the order of the list."""
        found: dict[int, dict[str, None]] = {}
        for meaning in self.meanings:
            found.setdefault(meaning.template, {})[meaning.command] = None
        return [tuple(names) for names in found.values() if len(names) > 1]

    def parse(self, text: str) -> Parse | None:
        """Find what a sentence means; None if it is not in the language.

        It may be typed with digits, capitals and a full stop, perhaps without accents.
        """
        words = text.split()
        label = self.label(words)
        if label is None:
            typed = spoken_forms(text, self.language)
            found = next(
                chain(
                    self._matching_sentences(typed),
                    self._matching_sentences(self._with_accents(typed)),
                ),
                None,
            )
            if found is None:
                return None
            words, label = found
        meaning = self.meanings[label]
        slots: Mapping[str, Value] = meaning.constants
        if meaning.reader:
            slots = {**slots, **(meaning.reader.slots(words) or {})}
        return Parse(" ".join(words), meaning.command, slots)

    @cached_property
    def _names(self) -> frozenset[str]:
        return frozenset(self.names)

    @cached_property
    def _plain_names(self) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        for name in self.names:
            found.setdefault(plain_form(name), []).append(name)
        return found

    def has_continuation(self, text: str) -> bool:
        """Whether a longer sentence begins with this text."""
        state = self.automaton.walk(text.split())
        return state is not None and bool(self.automaton.arcs[state])

    def may_be_extended(self, text: str) -> bool:
        """Whether a longer sentence adds something to the slots of this one, and changes none."""
        said, state = self.parse(text), self.automaton.walk(text.split())
        if said is None or not said.slots or state is None:
            return False
        longer = (self.parse(f"{text} {rest}") for rest in self.automaton.continuations(state))
        return any(
            more and more.command == said.command and more.slots.items() >= said.slots.items()
            for more in longer
        )

    def is_typed_prefix(self, text: str) -> bool:
        """Whether a longer sentence begins with a typed text, perhaps with digits."""
        return bool(words := spoken_forms(text, self.language)) and any(
            self.automaton.arcs[state] for state, _ in self._states_after(words)
        )

    def continuing_commands(self, text: str) -> frozenset[str]:
        """Return the commands of longer sentences that begin with this text."""
        begin = self.automaton.walk(text.split())
        if begin is None:
            return frozenset()
        found: set[str] = set()
        seen, waiting = {begin}, [begin]
        while waiting:
            for after in self.automaton.arcs[waiting.pop()].values():
                if self.automaton.labels[after] != NO_LABEL:
                    found.add(self.meanings[self.automaton.labels[after]].command)
                waiting += {after} - seen
                seen.add(after)
        return frozenset(found)

    def sample(self, number: int, seed: int = 0) -> list[str]:
        """Draw different sentences, each equally likely."""
        return self.automaton.sample(number, seed)

    def examples(self) -> list[str]:
        """Return all sentences if they can be listed; else a sample with all words."""
        if self.can_be_listed:
            return self.listed
        drawn = self.sample(MAX_LISTED_SENTENCES)
        return drawn + self.automaton.sentences_with_words(set(self.vocabulary) - _words(drawn))

    def named(self, names: Collection[str], most: int) -> list[str]:
        """Return sentences that mean one of some commands, or are named themselves.

        Of each template at most `most` are returned, the shortest first.
        """
        labels = [n for n, meaning in enumerate(self.meanings) if meaning.command in names]
        found = [
            text for label in labels for text in self.automaton.sentences_with_label(label, most)
        ]
        return list(dict.fromkeys([*found, *(text for text in names if text in self)]))

    def neighbors(self, text: str, most: int, sound: WordCosts) -> list[str]:
        """Find at most `most` sentences that sound like one of the language, the nearest first."""
        return [near.sentence for near in nearest(self.automaton, text.split(), sound, most)]

    def closest_sentence(self, text: str) -> str | None:
        """Guess which sentence was meant by a typed one; None if nothing is similar."""
        words = first_wording(text).split()[: self.longest + 3]
        found = nearest(self.automaton, words, LetterDistances(), 1, changes=len(words))
        close = found and found[0].cost <= MAX_WRONG_LETTERS * sum(map(len, words))
        return found[0].sentence if close else None

    def label(self, words: Sequence[str]) -> int | None:
        """Return the place of a sentence's meaning; None if it is no command."""
        state = self.automaton.walk(words)
        label = NO_LABEL if state is None else self.automaton.labels[state]
        return None if label == NO_LABEL else label

    def _with_accents(self, typed: Sequence[Sequence[str]]) -> list[list[str]]:
        """Return typed words with their accents, in all ways."""
        return [[word for way in ways for word in self._accents.get(way, [way])] for ways in typed]

    @cached_property
    def _accents(self) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        for word in self.vocabulary:
            found.setdefault(strip_accents(word), []).append(word)
        return found

    def _matching_sentences(
        self, typed: Sequence[Sequence[str]]
    ) -> Iterator[tuple[list[str], int]]:
        """Yield the sentences that typed text may be, with their labels."""
        for state, words in self._states_after(typed):
            if self.automaton.labels[state] != NO_LABEL:
                yield words, self.automaton.labels[state]

    def _states_after(self, typed: Sequence[Sequence[str]]) -> list[tuple[int, list[str]]]:
        """Return the states to which typed text leads, with the words on the way."""
        begun: list[tuple[int, list[str]]] = [(0, [])]
        for ways in typed:
            begun = [
                (after, [*words, *way.split()])
                for state, words in begun
                for way in ways
                if (after := self.automaton.walk(way.split(), state)) is not None
            ]
        return begun


def _words(sentences: Iterable[str]) -> set[str]:
    return {word for sentence in sentences for word in sentence.split()}


def plain_commands(sentences: Sequence[str]) -> Commands:
    """The commands of a plain list: each sentence is its own command."""
    meanings = [Meaning(sentence, template=number) for number, sentence in enumerate(sentences)]
    return Commands(prefix_tree(sentences), meanings)


class StoredCommands(msgspec.Struct, frozen=True):
    """What the `.templates` file of a language holds."""

    sources: dict[str, str]  # the SHA-256 of each template file, by its path relative to the folder
    arcs: list[dict[str, int]]  # of the automaton
    labels: list[int]  # of the automaton
    meanings: list[Meaning]  # of the labels


def encode_commands(commands: Commands, sources: Mapping[str, str]) -> str:
    """Write commands as JSON; deterministic."""
    automaton = commands.automaton
    stored = StoredCommands(
        dict(sources), automaton.arcs, automaton.labels, list(commands.meanings)
    )
    return msgspec.json.encode(stored).decode() + "\n"


def decode_commands(stored: StoredCommands, language: str = ENGLISH) -> Commands:
    """The reverse of `encode_commands`."""
    return Commands(Automaton(stored.arcs, stored.labels), stored.meanings, language)
