"""The YAML context of Picovoice's Rhino; pure.

In it `[a, b]` is a choice, `(a, b)` may be left out, `$list:slot` is a slot, `@macro` a rule.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction

from voz.language.formats.parser import Parser, Token
from voz.language.formats.yaml_text import Yaml
from voz.language.sentences.expression import (
    Concatenation,
    DefinitionKind,
    Expression,
    NumberRange,
    Reference,
    Slot,
    choice,
    phrase,
)
from voz.language.sentences.location import error_at
from voz.language.sentences.template_source import Template, TemplateSource

BUILT_IN_NUMBERS: Mapping[str, int] = {
    "SingleDigitInteger": 9,
    "TwoDigitInteger": 99,
    "Percent": 100,
}
"""The largest number of Rhino's built-in slots."""

LETTERS = "abcdefghijklmnopqrstuvwxyz"


class RhinoParser(Parser):
    """Parses an expression of Rhino."""

    TOKEN = re.compile(
        r"(?P<slot>\$[\w.]+(?::[\w]+)?)|(?P<macro>@[\w]+)|(?P<mark>[()\[\],])"
        r"|(?P<word>[^\s()\[\],$@]+)"
    )
    PARTS = ","
    OPTIONAL = ("(", ")")
    GROUP = ("[", "]")
    DIGITS = True

    def other(self, token: Token) -> Expression:
        """Parse a slot or a macro."""
        place = self.passage.place(token.at)
        if token.kind == "macro":
            return Reference("rule", token.text[1:], place)
        if token.kind == "slot":
            kind, _, name = token.text[1:].partition(":")
            if kind.startswith("pv."):
                slot = Slot(name or kind[3:], self._built_in(kind[3:], token), place)
                return Concatenation((slot, phrase("percent"))) if kind == "pv.Percent" else slot
            return Slot(name or kind, Reference("list", kind, place), place)
        return super().other(token)

    def _built_in(self, kind: str, token: Token) -> Expression:
        if kind == "Alphabetic":
            return choice([phrase(letter) for letter in LETTERS])
        if kind not in BUILT_IN_NUMBERS:
            known = ", ".join(f"$pv.{name}" for name in (*BUILT_IN_NUMBERS, "Alphabetic"))
            self.fail(f"supported slots of Rhino are {known}; use a list instead", token.at)
        return NumberRange(Fraction(0), Fraction(BUILT_IN_NUMBERS[kind]), Fraction(1))


def parse_rhino(text: Yaml) -> TemplateSource:
    """Parse a YAML context of Rhino; raises CommandsError."""
    source = TemplateSource(text.name)
    root = text.mapping(text.root, "the context")
    parts = text.mapping(root["context"], "expressions, slots and macros")
    if "expressions" not in parts:
        raise error_at(text.place(root["context"]), '"expressions" is missing')
    for intent, node in text.mapping(parts["expressions"], "the intents").items():
        for line in text.sequence(node, "expressions"):
            passage = text.text(line)
            template = Template(intent, RhinoParser(passage).parse(), passage.place())
            source.templates.append(template)
    sections: list[tuple[DefinitionKind, str]] = [("list", "slots"), ("rule", "macros")]
    for kind, section in sections:
        named = text.mapping(parts[section], section) if section in parts else {}
        for name, node in named.items():
            values = [RhinoParser(text.text(v)).parse() for v in text.sequence(node, "values")]
            if not values:
                raise error_at(text.place(node), "empty list; write its values")
            source.define(kind, name, choice(values), text.place(node))
    return source
