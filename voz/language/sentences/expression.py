"""A template as a tree that never changes: its names, number ranges and size; pure."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from math import factorial, prod
from typing import Literal, NamedTuple, TypeAlias

from voz.language.sentences.spelling import ENGLISH, wordings
from voz.language.sentences.text_lines import Location, error_at

DefinitionKind = Literal["rule", "list"]

DefinitionKey: TypeAlias = tuple[DefinitionKind, str]
"""The kind and name of a rule or a list."""

Value: TypeAlias = bool | str | int | float
"""Of a slot: words, a number, true or false."""


@dataclass(frozen=True, slots=True)
class Word:
    """One word, in lower case."""

    text: str


@dataclass(frozen=True, slots=True)
class Concatenation:
    """One item after the other; without items no word."""

    items: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several items; `synonyms` mean the same in every template, the first names it."""

    items: tuple[Expression, ...]
    synonyms: bool = False


@dataclass(frozen=True, slots=True)
class Optional:
    """An item or nothing."""

    item: Expression


@dataclass(frozen=True, slots=True)
class Permutation:
    """All items in any order."""

    items: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Tag:
    """An item with a value in place of its words."""

    item: Expression
    value: Value


@dataclass(frozen=True, slots=True)
class NumberRange:
    """A number in words: from first to last by step, in all usual wordings.

    Its value is the number times `factor`.
    """

    first: Fraction
    last: Fraction
    step: Fraction
    factor: Fraction = Fraction(1)
    language: str = ENGLISH


@dataclass(frozen=True, slots=True)
class Slot:
    """A slot; what is spoken here is its value."""

    name: str
    item: Expression
    place: Location = field(compare=False)


@dataclass(frozen=True, slots=True)
class Reference:
    """The name of a rule or a list that is defined elsewhere."""

    kind: DefinitionKind
    name: str
    place: Location = field(compare=False)


@dataclass(frozen=True, slots=True)
class ResolvedReference:
    """A reference with the expression of its rule or list, and whether that may have no word."""

    kind: DefinitionKind
    name: str
    item: Expression
    may_be_empty: bool = False


Expression: TypeAlias = (
    Word
    | Concatenation
    | Choice
    | Optional
    | Permutation
    | Tag
    | NumberRange
    | Slot
    | Reference
    | ResolvedReference
)

NO_WORDS = Concatenation(())


def children(item: Expression) -> tuple[Expression, ...]:
    """Return what an expression is made of."""
    if isinstance(item, (Concatenation, Choice, Permutation)):
        return item.items
    return (item.item,) if isinstance(item, (Optional, Tag, Slot, ResolvedReference)) else ()


def with_children(item: Expression, change: Callable[[Expression], Expression]) -> Expression:
    """Return an expression whose children are changed."""
    if isinstance(item, (Concatenation, Choice, Permutation)):
        return replace(item, items=tuple(map(change, item.items)))
    if isinstance(item, (Optional, Tag, Slot)):
        return replace(item, item=change(item.item))
    return item


def references(item: Expression) -> Iterator[Reference]:
    """Yield the names of rules and lists in an expression."""
    if isinstance(item, Reference):
        yield item
    for inner in children(item):
        yield from references(inner)


def renamed(item: Expression, names: Mapping[DefinitionKey, str]) -> Expression:
    """Give the references in an expression the names that are known elsewhere."""
    if isinstance(item, Reference):
        return replace(item, name=names.get((item.kind, item.name), item.name))
    return with_children(item, lambda one: renamed(one, names))


def numbers_in_language(item: Expression, language: str) -> Expression:
    """Let the numbers in an expression be said in a language; ValueError if nobody knows them."""
    if isinstance(item, NumberRange):
        wordings(item.first, language)
        return replace(item, language=language)
    return with_children(item, lambda one: numbers_in_language(one, language))


def concatenation(items: list[Expression]) -> Expression:
    """Join expressions one after the other; a single one stays as it is."""
    return items[0] if len(items) == 1 else Concatenation(tuple(items))


def choice(items: list[Expression], *, synonyms: bool = False) -> Expression:
    """Make a choice of expressions; a single one stays as it is."""
    different = tuple(dict.fromkeys(items))
    return different[0] if len(different) == 1 else Choice(different, synonyms)


def may_be_empty(item: Expression) -> bool:
    """Whether an expression may have no word: whatever it says may be left out."""
    if isinstance(item, Concatenation | Permutation):
        return all(map(may_be_empty, item.items))
    if isinstance(item, Choice):
        return any(map(may_be_empty, item.items))
    if isinstance(item, Tag | Slot):
        return may_be_empty(item.item)
    if isinstance(item, ResolvedReference):  # many may be within each other
        return item.may_be_empty
    return isinstance(item, Optional)


def phrase(text: str) -> Expression:
    """Make words in a row."""
    return concatenation([Word(word) for word in text.split()])


def plain_words(item: Expression) -> str | None:
    """Return the text of words in a row; None if it is something else."""
    if isinstance(item, Word):
        return item.text
    if isinstance(item, Concatenation) and all(isinstance(one, Word) for one in item.items):
        return " ".join(one.text for one in item.items if isinstance(one, Word))
    return None


def parse_value(text: str) -> Value:
    """Read a value; it is a number if it can be."""
    try:
        return (
            plain_number(Fraction(text))
            if text[:1] in "+-.0123456789" and "/" not in text
            else text
        )
    except ValueError:
        return text


def plain_number(number: Fraction) -> int | float:
    """Convert a whole number to int, and any other to float."""
    return int(number) if number.denominator == 1 else float(number)


MAX_RANGE_NUMBERS = 10_001


def check_range(numbers: NumberRange, place: Location) -> NumberRange:
    """Raise CommandsError if a range is empty, too long or has numbers that nobody says."""
    if numbers.step <= 0:
        raise error_at(place, "the step must be above 0")
    count = (numbers.last - numbers.first) // numbers.step + 1
    if count < 1:
        raise error_at(place, "empty range; write the smaller number first")
    if count > MAX_RANGE_NUMBERS:
        raise error_at(place, f"{count:,} numbers are too many; use a larger step")
    try:
        for number in numbers_in(numbers):
            wordings(number)
    except ValueError as error:
        raise error_at(place, f"{error}; use other numbers") from None
    return numbers


def numbers_in(numbers: NumberRange) -> list[Fraction]:
    """All numbers of a range."""
    count = (numbers.last - numbers.first) // numbers.step + 1
    return [numbers.first + n * numbers.step for n in range(count)]


@lru_cache(maxsize=1000)
def tagged_wordings(numbers: NumberRange) -> Expression:
    """Return all wordings of a range, tagged with their numbers; for two numbers, the smaller."""
    said: dict[str, Fraction] = {}
    for number in numbers_in(numbers):
        for text in wordings(number, numbers.language):
            said.setdefault(text, number)
    values = {number: plain_number(number * numbers.factor) for number in said.values()}
    return choice([Tag(phrase(text), values[number]) for text, number in said.items()])


class Size(NamedTuple):
    """The size of an expression."""

    ways: int  # number of sentences; one that it gives twice counts twice
    longest: int  # words of the longest


def size(item: Expression, known: dict[int, Size]) -> Size:
    """Measure an expression without references; `known` is a cache by id."""
    if isinstance(item, Word):
        return Size(1, 1)
    if isinstance(item, NumberRange):
        return _size_of_numbers(item)
    if isinstance(item, (Concatenation, Permutation)):
        each = [size(one, known) for one in item.items]
        orders = factorial(len(each)) if isinstance(item, Permutation) else 1
        return Size(orders * prod(one.ways for one in each), sum(one.longest for one in each))
    if isinstance(item, Choice):
        each = [size(one, known) for one in item.items]
        return Size(sum(one.ways for one in each), max(one.longest for one in each))
    if isinstance(item, Optional):
        inner = size(item.item, known)
        return Size(inner.ways + 1, inner.longest)
    if isinstance(item, ResolvedReference):
        if id(item) not in known:
            known[id(item)] = size(item.item, known)
        return known[id(item)]
    assert isinstance(item, (Tag, Slot)), Reference
    return size(item.item, known)


@lru_cache(maxsize=1000)
def _size_of_numbers(numbers: NumberRange) -> Size:
    return size(tagged_wordings(numbers), {})


def default_name(item: Expression) -> str:
    """Return the first sentence of a template without options; a slot is its name."""
    if may_be_empty(item) and not isinstance(item, Slot):
        return ""
    if isinstance(item, Word):
        return item.text
    if isinstance(item, Slot):
        return f"{{{item.name}}}"
    if isinstance(item, (Concatenation, Permutation)):
        return " ".join(filter(None, map(default_name, item.items)))
    if isinstance(item, Choice):
        return default_name(item.items[0])
    if isinstance(item, (Tag, ResolvedReference)):
        return default_name(item.item)
    return default_name(tagged_wordings(item)) if isinstance(item, NumberRange) else ""
