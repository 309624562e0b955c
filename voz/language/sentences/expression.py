"""A template as a tree that never changes, and the names in it; pure."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Literal, TypeAlias

from voz.language.sentences.location import Location

DefinitionKind = Literal["rule", "list"]

DefinitionKey: TypeAlias = tuple[DefinitionKind, str]
"""The kind and name of a rule or a list."""

Value: TypeAlias = str | int | float
"""Of a slot: words, or a number."""


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
    """One of several items."""

    items: tuple[Expression, ...]


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
    """A number in words: from first to last by step, in all usual wordings."""

    first: Fraction
    last: Fraction
    step: Fraction


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
    """A reference with the expression of its rule or list."""

    kind: DefinitionKind
    name: str
    item: Expression


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


def concatenation(items: list[Expression]) -> Expression:
    """Join expressions one after the other; a single one stays as it is."""
    return items[0] if len(items) == 1 else Concatenation(tuple(items))


def choice(items: list[Expression]) -> Expression:
    """Make a choice of expressions; a single one stays as it is."""
    return items[0] if len(items) == 1 else Choice(tuple(items))


def phrase(text: str) -> Expression:
    """Make words in a row."""
    return concatenation([Word(word) for word in text.split()])


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
