"""The contents of a file of templates, in whatever format it is written; pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from voz.language.sentences.expression import DefinitionKey, DefinitionKind, Expression, Value
from voz.language.sentences.location import Location, error_at


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
