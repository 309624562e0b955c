"""Counts the sentences of an expression without listing them; pure."""

from __future__ import annotations

from functools import lru_cache
from math import factorial, prod
from typing import NamedTuple

from voz.language.sentences.expression import (
    Choice,
    Concatenation,
    Expression,
    NumberRange,
    Optional,
    Permutation,
    Reference,
    ResolvedReference,
    Slot,
    Tag,
    Word,
)
from voz.language.sentences.number_range import tagged_wordings


class Size(NamedTuple):
    """The size of an expression.

    Attributes:
        ways: number of sentences; one that it gives twice counts twice.
        longest: words of the longest.
    """

    ways: int
    longest: int


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
