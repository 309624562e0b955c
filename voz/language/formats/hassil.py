"""The YAML of hassil, of Home Assistant's intents and of speech-to-phrase; pure.

https://github.com/OHF-Voice/hassil has intents with `data`, speech-to-phrase `data` alone.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from voz.language.formats.notation import Notation
from voz.language.formats.yaml_text import Yaml
from voz.language.sentences.expression import (
    DefinitionKey,
    Expression,
    NumberRange,
    Tag,
    Value,
    choice,
    parse_value,
    renamed,
)
from voz.language.sentences.location import Location, error_at
from voz.language.sentences.number_range import check_range
from voz.language.sentences.template_source import Template, TemplateSource

if TYPE_CHECKING:
    from yaml import Node

SENTENCE_SECTIONS = ("intents", "data")
"""Every file with sentences has one of them."""

CONTEXT_KEYS = {"requires_context", "excludes_context"}
"""Conditions on sentences, which are not supported."""


class HassilNotation(Notation):
    """voz's notation with numbers in digits."""

    DIGITS = True


def parse_hassil(text: Yaml) -> TemplateSource:
    """Parse a YAML file of hassil; raises CommandsError."""
    source = TemplateSource(text.name)
    parts = text.mapping(text.root, "intents, lists and expansion_rules")
    _definitions(text, source, parts, "")
    for name in ("wildcards", "skip_words"):
        if name in parts and text.sequence(parts[name], "words"):
            raise error_at(text.place(parts[name]), _WHY[name])
    if "intents" in parts:
        for intent, node in text.mapping(parts["intents"], "the intents").items():
            block = text.mapping(node, "the data of the intent")
            if "data" not in block:
                raise error_at(text.place(node), '"data" is missing; add the sentences')
            for number, data in enumerate(text.sequence(block["data"], "sentences"), start=1):
                _block(text, source, intent, data, f"{intent}.{number}.")
    if "data" in parts:
        for number, node in enumerate(text.sequence(parts["data"], "sentences"), start=1):
            _block(text, source, None, node, f"data.{number}.")
    return source


_WHY = {
    "wildcards": "wildcards are not supported; write the values as a list",
    "skip_words": "skip words are not supported; write [please] where they may stand",
    "wildcard": "wildcards are not supported; write the values",
}


def _block(text: Yaml, source: TemplateSource, intent: str | None, node: Node, scope: str) -> None:
    """Add the sentences of one intent, with its own lists and rules."""
    from yaml import MappingNode

    if not isinstance(node, MappingNode):
        source.templates.append(_sentence(text, intent, node, {}, {}))
        return
    parts = text.mapping(node, "sentences")
    for name in CONTEXT_KEYS & parts.keys():
        raise error_at(
            text.place(parts[name]), f"{name} is not supported; remove it or these sentences"
        )
    names = _definitions(text, source, parts, scope)
    constants: dict[str, Value] = {}
    for slot, value in text.mapping(parts["slots"], "slots").items() if "slots" in parts else ():
        constants[slot] = parse_value(text.text(value).text)
    if "sentences" not in parts:
        raise error_at(text.place(node), '"sentences" is missing')
    for sentence in text.sequence(parts["sentences"], "sentences"):
        source.templates.append(_sentence(text, intent, sentence, constants, names))


def _sentence(
    text: Yaml,
    intent: str | None,
    node: Node,
    constants: dict[str, Value],
    names: dict[DefinitionKey, str],
) -> Template:
    passage = text.text(node)
    expression = renamed(HassilNotation(passage).parse(), names)
    return Template(intent, expression, passage.place(), constants)


def _definitions(
    text: Yaml, source: TemplateSource, parts: dict[str, Node], scope: str
) -> dict[DefinitionKey, str]:
    """Add lists and rules; return the global names of one intent's own."""
    lists = text.mapping(parts["lists"], "lists") if "lists" in parts else {}
    rules = text.mapping(parts["expansion_rules"], "rules") if "expansion_rules" in parts else {}
    names: dict[DefinitionKey, str] = {}
    if scope:
        names.update((("list", name), scope + name) for name in lists)
        names.update((("rule", name), scope + name) for name in rules)
    for name, node in lists.items():
        source.define("list", scope + name, renamed(_list(text, node), names), text.place(node))
    for name, node in rules.items():
        body = renamed(HassilNotation(text.text(node)).parse(), names)
        source.define("rule", scope + name, body, text.place(node))
    return names


def _list(text: Yaml, node: Node) -> Expression:
    from yaml import MappingNode

    place = text.place(node)
    if isinstance(node, MappingNode):
        parts = text.mapping(node, "values")
        if "wildcard" in parts:
            raise error_at(place, _WHY["wildcard"])
        if "range" in parts:
            return _range(text, parts["range"], place)
        if "values" not in parts:
            raise error_at(place, '"values" is missing')
        node = parts["values"]
    values = [_value(text, value) for value in text.sequence(node, "values")]
    if not values:
        raise error_at(place, "empty list; write its values")
    return choice(values)


def _value(text: Yaml, node: Node) -> Expression:
    from yaml import MappingNode

    if not isinstance(node, MappingNode):
        return HassilNotation(text.text(node)).parse()
    parts = text.mapping(node, "in and out")
    if "in" not in parts:
        raise error_at(text.place(node), '"in" is missing; add what is said')
    spoken = HassilNotation(text.text(parts["in"])).parse()
    return Tag(spoken, parse_value(text.text(parts["out"]).text)) if "out" in parts else spoken


def _range(text: Yaml, node: Node, place: Location) -> NumberRange:
    parts = {name: text.text(value).text for name, value in text.mapping(node, "from, to").items()}
    if unknown := {"multiplier", "fractions"} & parts.keys():
        raise error_at(place, f"{min(unknown)} is not supported; use only from, to and step")
    try:
        first, last = Fraction(parts["from"]), Fraction(parts["to"])
        step = Fraction(parts.get("step", "1"))
    except (KeyError, ValueError, ZeroDivisionError):
        raise error_at(place, "invalid range; write it as from: 0, to: 100, step: 5") from None
    return check_range(NumberRange(first, last, step), place)
