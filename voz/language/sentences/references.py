"""The names of rules and lists in an expression; pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

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
from voz.language.sentences.template_source import DefinitionKind


def references(item: Expression) -> Iterator[Reference]:
    """The names in an expression."""
    if isinstance(item, Reference):
        yield item
    for inner in inside(item):
        yield from references(inner)


def renamed(item: Expression, names: Mapping[tuple[DefinitionKind, str], str]) -> Expression:
    """Let the references in an expression have the names that are known elsewhere."""
    if isinstance(item, Reference):
        return replace(item, name=names.get((item.kind, item.name), item.name))
    if isinstance(item, (Concatenation, Choice, Permutation)):
        return replace(item, items=tuple(renamed(one, names) for one in item.items))
    if isinstance(item, (Word, NumberRange, ResolvedReference)):
        return item
    return replace(item, item=renamed(item.item, names))


def inside(item: Expression) -> Iterable[Expression]:
    """What an expression is made of."""
    if isinstance(item, (Concatenation, Choice, Permutation)):
        return item.items
    return (item.item,) if isinstance(item, (Optional, Tag, Slot, ResolvedReference)) else ()
