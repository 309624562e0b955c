"""Templates with their rules and lists, whatever the format of their file; pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TypeAlias

from voz.language.sentences.expression import (
    Concatenation,
    DefinitionKey,
    DefinitionKind,
    Expression,
    Permutation,
    Reference,
    ResolvedReference,
    Slot,
    Value,
    children,
    references,
    with_children,
)
from voz.language.sentences.text_lines import Location, error_at


@dataclass(frozen=True)
class Template:
    """Sentences that mean one command.

    Attributes:
        command: its name; None if the template itself names it.
        expression: the sentences.
        place: where it stands.
        constants: slots with fixed values.
    """

    command: str | None
    expression: Expression
    place: Location
    constants: Mapping[str, Value] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True)
class Definition:
    """The expression of a rule or a list, and its place."""

    expression: Expression
    place: Location


@dataclass
class TemplateSource:
    """The contents of a file and of those that it imports.

    Attributes:
        name: what messages call the file.
        templates: in their order.
        definitions: of rules and lists, by kind and name.
        imports: names of other files, and where they are named.
    """

    name: str
    templates: list[Template] = field(default_factory=list)
    definitions: dict[DefinitionKey, Definition] = field(default_factory=dict)
    imports: list[tuple[str, Location]] = field(default_factory=list)

    def define(
        self, kind: DefinitionKind, name: str, expression: Expression, place: Location
    ) -> None:
        """Add a rule or list; raises CommandsError if the name is taken."""
        if before := self.definitions.get((kind, name)):
            raise error_at(
                place, f'the {kind} "{name}" is already defined ({before.place}); use another name'
            )
        self.definitions[kind, name] = Definition(expression, place)

    def add(self, other: TemplateSource) -> None:
        """Add the contents of an imported file; raises CommandsError if a name is taken."""
        self.templates += other.templates
        for (kind, name), definition in other.definitions.items():
            self.define(kind, name, definition.expression, definition.place)


def reference_text(kind: DefinitionKind, name: str) -> str:
    """A reference as it is written in a template."""
    return f"<{name}>" if kind == "rule" else f"{{{name}}}"


MAX_REFERENCE_DEPTH = 30
"""Rules within rules; Python's own limit is not far above."""


def resolve(source: TemplateSource) -> tuple[list[Template], tuple[str, ...]]:
    """Replace references by their definitions.

    Returns:
        The templates without references, and a warning for each unused name.

    Raises:
        CommandsError: a name is undefined or contains itself, or a sentence has a slot twice.
    """
    resolver = _Resolver(source)
    templates = []
    for template in source.templates:
        expression = resolver.resolved(template.expression)
        slots(expression, resolver.slots)
        templates.append(replace(template, expression=expression))
    unused = []
    for (kind, name), definition in source.definitions.items():
        if (kind, name) not in resolver.known:
            resolver.named(kind, name, definition.place)  # it may still be wrong
            unused.append(
                f"{definition.place}: {kind} {reference_text(kind, name)} is never used; remove it"
            )
    return templates, tuple(unused)


class _Resolver:
    def __init__(self, source: TemplateSource) -> None:
        self._source = source
        self._open: list[DefinitionKey] = []
        self.known: dict[DefinitionKey, ResolvedReference] = {}
        self.slots: dict[int, Slots] = {}
        self._depths: dict[DefinitionKey, int] = {}

    def named(self, kind: DefinitionKind, name: str, place: Location) -> ResolvedReference:
        if (kind, name) in self.known:
            return self.known[kind, name]
        if (kind, name) in self._open:
            round_about = [*self._open[self._open.index((kind, name)) :], (kind, name)]
            path = " in ".join(reference_text(*one) for one in reversed(round_about))
            raise error_at(place, f"{path} is recursive; write the words instead")
        definition = self._source.definitions.get((kind, name))
        if definition is None:
            raise error_at(place, self._unknown(kind, name))
        if len(self._open) > MAX_REFERENCE_DEPTH:
            raise error_at(place, f"more than {MAX_REFERENCE_DEPTH} nested names; use fewer")
        self._open.append((kind, name))
        item = self.resolved(definition.expression)
        self._open.pop()
        held = [(found.kind, found.name) for found in references(definition.expression)]
        depth = self._depths[kind, name] = 1 + max((self._depths[one] for one in held), default=0)
        if depth > MAX_REFERENCE_DEPTH:
            raise error_at(
                definition.place,
                f"more than {MAX_REFERENCE_DEPTH} nested names; use fewer",
            )
        if kind == "list" and (inner := slots(item, self.slots)):
            raise error_at(definition.place, f"a list cannot hold a slot, as {{{min(inner)}}}")
        found = self.known[kind, name] = ResolvedReference(kind, name, item)
        return found

    def _unknown(self, kind: DefinitionKind, name: str) -> str:
        other: DefinitionKind = "rule" if kind == "list" else "list"
        if (other, name) in self._source.definitions:
            return f'"{name}" is a {other}; write {reference_text(other, name)}'
        head = reference_text(kind, name) if kind == "rule" else name
        says = "would you | please" if kind == "rule" else "red | green"
        return f'there is no {kind} "{name}"; add a line, as in: {head} = {says}'

    def resolved(self, item: Expression) -> Expression:
        """Return an expression without references."""
        if isinstance(item, Reference):
            return self.named(item.kind, item.name, item.place)
        return with_children(item, self.resolved)


Slots: TypeAlias = Mapping[str, Slot]


def slots(item: Expression, known: dict[int, Slots]) -> Slots:
    """Find the slots of an expression without references.

    Args:
        item: the expression.
        known: cache of the slots of resolved references, by id.

    Raises:
        CommandsError: a sentence has a slot twice, or one inside another.
    """
    if id(item) in known:
        return known[id(item)]
    each = [slots(inner, known) for inner in children(item)]
    if isinstance(item, (Concatenation, Permutation)):
        _check_twice(each)
    merged = {name: slot for found in each for name, slot in found.items()}
    if isinstance(item, Slot):
        if merged:
            raise error_at(item.place, f'the slot "{item.name}" contains another; separate them')
        return {item.name: item}
    if isinstance(item, ResolvedReference):
        known[id(item)] = merged
    return merged


def _check_twice(each: Iterable[Slots]) -> None:
    named: set[str] = set()
    for found in each:
        if twice := named & found.keys():
            name = min(twice)
            raise error_at(
                found[name].place,
                f'the slot "{name}" occurs twice in one sentence; rename one, '
                f"as in {{{name}:other}}",
            )
        named |= found.keys()
