"""Templates with their rules and lists, whatever the format of their file; pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import NamedTuple, TypeAlias

from voz.errors import CommandsError
from voz.language.sentences.expression import (
    Concatenation,
    DefinitionKey,
    DefinitionKind,
    Expression,
    Optional,
    Permutation,
    Reference,
    ResolvedReference,
    Slot,
    Value,
    children,
    choice,
    may_be_empty,
    numbers_in_language,
    references,
    with_children,
)
from voz.language.sentences.text_lines import Location, error_at, summarize_warnings


@dataclass(frozen=True)
class Template:
    """Sentences that mean one command."""

    command: str | None  # its name; None if the template itself names it
    expression: Expression  # the sentences
    place: Location  # where it stands
    # Slots with fixed values.
    constants: Mapping[str, Value] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True)
class Definition:
    """The expression of a rule or a list, and its place.

    What cannot be supported has a reason, and sentences that need it are left out.
    """

    expression: Expression
    place: Location
    unsupported: str = ""


class Advice(NamedTuple):
    """How a rule, a list and a sentence are written in a file; `NAME` stands for a name."""

    rule: str = "<NAME> = would you | please"
    list: str = "NAME = red | green"
    sentence: str = "write one sentence per line"
    name: str = "give it a name, as in NAME: ..., or write what differs as a slot, as in {color}"


VOZ_ADVICE = Advice()


@dataclass
class TemplateSource:
    """The contents of a file and of those that it imports."""

    name: str  # what messages call the file
    templates: list[Template] = field(default_factory=list)  # in their order
    # Of rules and lists, by kind and name.
    definitions: dict[DefinitionKey, Definition] = field(default_factory=dict)
    # Names of other files, and where they are named.
    imports: list[tuple[str, Location]] = field(default_factory=list)
    # Whether what voz's own notation refuses is a warning, as the program that the file is for
    # takes it.
    lenient: bool = False
    skipped: Expression | None = None  # what may be said before and after every sentence
    warnings: list[str] = field(default_factory=list)  # what the user should know, one line each
    # Which sentences are left out and why, one line each.
    left_out: list[str] = field(default_factory=list)
    advice: Advice = VOZ_ADVICE  # how something that is missing is written in this file

    def define(
        self,
        kind: DefinitionKind,
        name: str,
        expression: Expression,
        place: Location,
        unsupported: str = "",
    ) -> None:
        """Add a rule or list; raises CommandsError if the name is taken."""
        before = self.definitions.get((kind, name))
        if before and before.expression == expression:
            self.warnings.append(f'{place}: the {kind} "{name}" is there twice ({before.place})')
        elif before:
            raise error_at(
                place, f'the {kind} "{name}" is already defined ({before.place}); use another name'
            )
        else:
            self.definitions[kind, name] = Definition(expression, place, unsupported)

    def add(self, other: TemplateSource) -> None:
        """Add the contents of an imported file; raises CommandsError if a name is taken."""
        self.templates += other.templates
        self.warnings += other.warnings
        self.left_out += other.left_out
        self.lenient |= other.lenient
        skipped = [one.skipped for one in (self, other) if one.skipped]
        self.skipped = choice(skipped) if skipped else None
        for (kind, name), definition in other.definitions.items():
            self.define(kind, name, definition.expression, definition.place, definition.unsupported)


def in_language(source: TemplateSource, language: str) -> TemplateSource:
    """Let all numbers be said in a language; raises CommandsError if nobody knows them."""

    def said(item: Expression) -> Expression:
        return numbers_in_language(item, language)

    try:
        return replace(
            source,
            templates=[replace(one, expression=said(one.expression)) for one in source.templates],
            definitions={
                key: replace(definition, expression=said(definition.expression))
                for key, definition in source.definitions.items()
            },
            skipped=said(source.skipped) if source.skipped else None,
        )
    except ValueError as error:
        raise CommandsError(f"{source.name}: {error}") from None


def reference_text(kind: DefinitionKind, name: str) -> str:
    """A reference as it is written in a template."""
    return f"<{name}>" if kind == "rule" else f"{{{name}}}"


LISTS_OF_HOME_ASSISTANT = ("name", "area", "floor")

MAX_REFERENCE_DEPTH = 30
"""Rules within rules; Python's own limit is not far above."""


def resolve(source: TemplateSource) -> tuple[list[Template], tuple[str, ...]]:
    """Replace references by their definitions.

    Returns:
        The templates without references, and what the user should know.

    Raises:
        CommandsError: a name is undefined or contains itself, or a sentence has a slot twice.
    """
    resolver = _Resolver(source)
    templates, warnings, left_out = [], list(source.warnings), list(source.left_out)
    named: set[DefinitionKey] = set()  # in sentences that are left out
    for template in source.templates:
        try:
            expression = resolver.resolved(template.expression)
        except _UnsupportedError as error:
            left_out.append(f"{template.place}: this sentence is left out, as {error}")
            _note_names(source, template.expression, named)
            continue
        twice: list[Slot] = []
        slots(expression, resolver.slots, twice)
        for slot in twice:
            what = f'the slot "{slot.name}" occurs twice in one sentence'
            if not source.lenient:
                raise error_at(slot.place, f"{what}; rename one, as in {{{slot.name}:other}}")
            warnings.append(f"{slot.place}: {what} ({template.place}); the last one counts")
        if source.skipped:
            may_be = _up_to_two(resolver.resolved(source.skipped))
            expression = Concatenation((may_be, expression, may_be))
        templates.append(replace(template, expression=expression))
    summary = (
        f"{source.name}: sentences are left out in {len(left_out)} places: see docs/sentences.md"
    )
    warnings[:0] = summarize_warnings(left_out, summary)
    for (kind, name), definition in source.definitions.items():
        if not (definition.unsupported or (kind, name) in {*resolver.known, *named}):
            resolver.named(kind, name, definition.place)  # it may still be wrong
            warnings.append(
                f"{definition.place}: {kind} {reference_text(kind, name)} is never used; remove it"
            )
    return templates, tuple(dict.fromkeys(warnings))


def _up_to_two(words: Expression) -> Expression:
    """Return what lets one or two of some words be said, as in `could you please`."""
    return Optional(Concatenation((words, Optional(words))))


def _note_names(source: TemplateSource, item: Expression, named: set[DefinitionKey]) -> None:
    """Add the names of rules and lists in an expression, and in what they name."""
    for found in references(item):
        key = found.kind, found.name
        if key not in named and (definition := source.definitions.get(key)):
            named.add(key)
            _note_names(source, definition.expression, named)


class _UnsupportedError(Exception):
    """A sentence needs what is not supported; the message says what."""


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
        if definition.unsupported:
            raise _UnsupportedError(f'{definition.unsupported} ("{name}", {definition.place})')
        if len(self._open) > MAX_REFERENCE_DEPTH:
            raise error_at(place, f"more than {MAX_REFERENCE_DEPTH} nested names; use fewer")
        self._open.append((kind, name))
        try:
            item = self.resolved(definition.expression)
        finally:
            self._open.pop()
        held = [(found.kind, found.name) for found in references(definition.expression)]
        depth = self._depths[kind, name] = 1 + max((self._depths[one] for one in held), default=0)
        if depth > MAX_REFERENCE_DEPTH:
            raise error_at(
                definition.place,
                f"more than {MAX_REFERENCE_DEPTH} nested names; use fewer",
            )
        if kind == "list" and (inner := slots(item, self.slots, [])):
            raise error_at(definition.place, f"a list cannot hold a slot, as {{{min(inner)}}}")
        found = self.known[kind, name] = ResolvedReference(kind, name, item, may_be_empty(item))
        return found

    def _unknown(self, kind: DefinitionKind, name: str) -> str:
        other: DefinitionKind = "rule" if kind == "list" else "list"
        if (other, name) in self._source.definitions and (other, name) not in self._open:
            return f'"{name}" is a {other}; write {reference_text(other, name)}'
        advice = self._source.advice
        how = (advice.rule if kind == "rule" else advice.list).replace("NAME", name)
        own = " (Home Assistant fills it itself)" if name in LISTS_OF_HOME_ASSISTANT else ""
        return f'there is no {kind} "{name}"{own}; add it, as in: {how}'

    def resolved(self, item: Expression) -> Expression:
        """Return an expression without references."""
        if isinstance(item, Reference):
            return self.named(item.kind, item.name, item.place)
        return with_children(item, self.resolved)


Slots: TypeAlias = Mapping[str, Slot]


def slots(item: Expression, known: dict[int, Slots], twice: list[Slot]) -> Slots:
    """Find the slots of an expression without references; raises CommandsError for one in another.

    `known` caches those of resolved references, by id; `twice` gets each slot that a sentence has
    already.
    """
    if id(item) in known:
        return known[id(item)]
    each = [slots(inner, known, twice) for inner in children(item)]
    if isinstance(item, (Concatenation, Permutation)):
        named: set[str] = set()
        for found in each:
            twice += (found[name] for name in sorted(named & found.keys()))
            named |= found.keys()
    merged = {name: slot for found in each for name, slot in found.items()}
    if isinstance(item, Slot):
        if merged:
            raise error_at(item.place, f'the slot "{item.name}" contains another; separate them')
        return {item.name: item}
    if isinstance(item, ResolvedReference):
        known[id(item)] = merged
    return merged
