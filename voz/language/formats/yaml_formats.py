"""The YAML of hassil (Home Assistant, speech-to-phrase) and of Picovoice's Rhino; pure."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import NoReturn

import yaml

from voz.language.formats.notation import Notation
from voz.language.formats.parser import Parser, Token
from voz.language.sentences.expression import (
    NO_WORDS,
    Concatenation,
    DefinitionKey,
    DefinitionKind,
    Expression,
    NumberRange,
    Reference,
    Slot,
    Tag,
    Value,
    check_range,
    choice,
    parse_value,
    phrase,
    renamed,
)
from voz.language.sentences.templates import Advice, Template, TemplateSource
from voz.language.sentences.text_lines import Faults, Location, Passage, error_at, numbered_lines


class Yaml:
    """A YAML file; its methods raise CommandsError where something else is expected."""

    def __init__(self, data: bytes, name: str) -> None:
        """Parse it; raises CommandsError."""
        self.name = name
        self._lines = [line for _, line in numbered_lines(data, name)]
        try:
            root = yaml.compose("\n".join(self._lines), Loader=yaml.SafeLoader)
        except yaml.MarkedYAMLError as error:
            self._broken(error)
        except (yaml.YAMLError, RecursionError) as error:
            raise error_at(Location(name, 1), f"invalid YAML ({error})") from None
        if root is None:
            raise error_at(Location(name, 1), "is empty; write intents and their sentences")
        self.root = root
        self.warnings = list(self._repeated_keys(root, set()))

    def _broken(self, error: yaml.MarkedYAMLError) -> NoReturn:
        mark = error.problem_mark
        line = min(mark.line, len(self._lines) - 1) if mark else 0
        place = Location(self.name, line + 1, mark.column + 1 if mark else 0, self._lines[line])
        raise error_at(place, f"invalid YAML: {error.problem or error.context}") from None

    def _repeated_keys(self, node: yaml.Node, seen: set[int]) -> Iterator[str]:
        """Report parts that are there twice; raise where they differ, as YAML takes the last."""
        if id(node) in seen or isinstance(node, yaml.ScalarNode):
            return
        seen.add(id(node))
        parts: dict[str, tuple[yaml.Node, yaml.Node]] = {}
        for key, value in node.value if isinstance(node, yaml.MappingNode) else ():
            name = yaml.serialize(key)
            if name in parts:
                first, before = parts[name]
                told = f'"{key.value}" is there twice (first in line {first.start_mark.line + 1})'
                if yaml.serialize(before) != yaml.serialize(value):
                    raise error_at(self.place(key), f"{told}; write what is in both into one")
                yield f"{self.place(key)}: {told}"
            parts[name] = (key, value)
            yield from self._repeated_keys(value, seen)
        for value in node.value if isinstance(node, yaml.SequenceNode) else ():
            yield from self._repeated_keys(value, seen)

    def place(self, node: yaml.Node) -> Location:
        """Return where a part begins."""
        return self.text(node).place() if isinstance(node, yaml.ScalarNode) else self._begin(node)

    def _begin(self, node: yaml.Node) -> Location:
        mark = node.start_mark
        return Location(self.name, mark.line + 1, mark.column + 1, self._lines[mark.line])

    def mapping(self, node: yaml.Node, what: str) -> dict[str, yaml.Node]:
        """Return the parts of a mapping by name; messages call it `what`."""
        if not isinstance(node, yaml.MappingNode):
            raise error_at(self.place(node), f"expected {what}, as in: name: ...")
        return {self.text(key).text: value for key, value in node.value}

    def sequence(self, node: yaml.Node, what: str) -> list[yaml.Node]:
        """Return the parts of a sequence; messages call them `what`."""
        if not isinstance(node, yaml.SequenceNode):
            raise error_at(self.place(node), f'expected {what}, one per line after "-"')
        return list(node.value)

    def text(self, node: yaml.Node) -> Passage:
        """Return a text with its place."""
        mark = node.start_mark
        if not isinstance(node, yaml.ScalarNode):
            raise error_at(self._begin(node), "expected a text")
        quoted = 1 if node.style in ("'", '"') else 0
        text = " ".join(str(node.value).split("\n"))
        return Passage(
            self.name, mark.line + 1, mark.column + quoted, text, self._lines[mark.line] or " "
        )


SENTENCE_SECTIONS = ("intents", "data", "sentences")
"""Every file with sentences has one of them."""

CONTEXT_KEYS = ("requires_context", "excludes_context")
"""Conditions on sentences, which are not supported."""

HASSIL_ADVICE = Advice(
    rule='expansion_rules: {NAME: "would you | please"}',
    list="lists: {NAME: {values: [red, green]}}",
    sentence="write intents and their sentences",
    name="make it an intent, or write what differs as a list, as in {color}",
)


class HassilNotation(Notation):
    """voz's notation, in which an alternative may be empty."""

    EMPTY = True


def parse_hassil(text: Yaml) -> TemplateSource:
    """Parse a YAML file of hassil; raises CommandsError."""
    source, faults = TemplateSource(text.name, lenient=True, advice=HASSIL_ADVICE), Faults()
    source.warnings += text.warnings
    parts = text.mapping(text.root, "intents, lists and expansion_rules")
    with faults:
        _definitions(text, source, parts, "")
    if "intents" in parts:
        for intent, node in text.mapping(parts["intents"], "the intents").items():
            block = text.mapping(node, "the data of the intent")
            if "data" not in block:
                raise error_at(text.place(node), '"data" is missing; add the sentences')
            for number, data in enumerate(text.sequence(block["data"], "sentences"), start=1):
                with faults:
                    _block(text, source, intent, data, f"{intent}.{number}.")
    if "data" in parts:
        for number, node in enumerate(text.sequence(parts["data"], "sentences"), start=1):
            with faults:
                _block(text, source, None, node, f"data.{number}.")
    for node in text.sequence(parts["sentences"], "sentences") if "sentences" in parts else ():
        with faults:
            source.templates += _corrected(text, node)
    faults.check()
    if "skip_words" in parts and (words := text.sequence(parts["skip_words"], "words")):
        source.skipped = choice([HassilNotation(text.text(word)).parse() for word in words])
    return source


def _corrected(text: Yaml, node: yaml.Node) -> list[Template]:
    """Return the templates of a sentence of wyoming-vosk, which may have an `in` and an `out`."""
    if not isinstance(node, yaml.MappingNode):
        return [_sentence(text, None, node, {}, {})]
    parts = text.mapping(node, "in and out")
    if "in" not in parts:
        raise error_at(text.place(node), '"in" is missing; add what is said')
    said = parts["in"]
    command = text.text(parts["out"]).text if "out" in parts else None
    each = said.value if isinstance(said, yaml.SequenceNode) else [said]
    return [_sentence(text, command, one, {}, {}) for one in each]


def _block(
    text: Yaml, source: TemplateSource, intent: str | None, node: yaml.Node, scope: str
) -> None:
    """Add the sentences of one intent, with its own lists and rules."""
    if not isinstance(node, yaml.MappingNode):
        source.templates.append(_sentence(text, intent, node, {}, {}))
        return
    parts = text.mapping(node, "sentences")
    if "sentences" not in parts:
        raise error_at(text.place(node), '"sentences" is missing')
    sentences = text.sequence(parts["sentences"], "sentences")
    if condition := next((name for name in CONTEXT_KEYS if name in parts), None):
        source.left_out.append(
            f"{text.place(parts[condition])}: {len(sentences)} sentences are left out, as "
            f"{condition} is not supported"
        )
        return
    names = _definitions(text, source, parts, scope)
    constants: dict[str, Value] = {}
    for slot, value in text.mapping(parts["slots"], "slots").items() if "slots" in parts else ():
        constants[slot] = parse_value(text.text(value).text)
    for sentence in sentences:
        source.templates.append(_sentence(text, intent, sentence, constants, names))


def _sentence(
    text: Yaml,
    intent: str | None,
    node: yaml.Node,
    constants: dict[str, Value],
    names: dict[DefinitionKey, str],
) -> Template:
    passage = text.text(node)
    expression = renamed(HassilNotation(passage).parse(), names)
    return Template(intent, expression, passage.place(), constants)


def _definitions(
    text: Yaml, source: TemplateSource, parts: dict[str, yaml.Node], scope: str
) -> dict[DefinitionKey, str]:
    """Add lists and rules; return the global names of one intent's own."""
    lists = text.mapping(parts["lists"], "lists") if "lists" in parts else {}
    rules = text.mapping(parts["expansion_rules"], "rules") if "expansion_rules" in parts else {}
    names: dict[DefinitionKey, str] = {}
    if scope:
        names.update((("list", name), scope + name) for name in lists)
        names.update((("rule", name), scope + name) for name in rules)
    for name, node in lists.items():
        place = text.place(node)
        if unsupported := _unsupported(text, node):
            source.define("list", scope + name, NO_WORDS, place, unsupported)
        else:
            source.define("list", scope + name, renamed(_list(text, node), names), place)
    for name, node in rules.items():
        body = renamed(HassilNotation(text.text(node)).parse(), names)
        source.define("rule", scope + name, body, text.place(node))
    return names


def _unsupported(text: Yaml, node: yaml.Node) -> str:
    """Return what of a list is not supported; empty if all is."""
    parts = text.mapping(node, "values") if isinstance(node, yaml.MappingNode) else {}
    if "wildcard" in parts:
        return "wildcards are not supported"
    values = parts.get("values", node)
    for value in values.value if isinstance(values, yaml.SequenceNode) else ():
        if isinstance(value, yaml.MappingNode):
            out = text.mapping(value, "in and out").get("out")
            if out is not None and not isinstance(out, yaml.ScalarNode):
                return "values that are lists are not supported"
    return ""


def _list(text: Yaml, node: yaml.Node) -> Expression:
    place = text.place(node)
    if isinstance(node, yaml.MappingNode):
        parts = text.mapping(node, "values")
        if "range" in parts:
            return _range(text, parts["range"], place)
        if "values" not in parts:
            raise error_at(place, '"values" is missing')
        node = parts["values"]
    values = [_value(text, value) for value in text.sequence(node, "values")]
    if not values:
        raise error_at(place, "empty list; write its values")
    return choice(values)


def _value(text: Yaml, node: yaml.Node) -> Expression:
    if not isinstance(node, yaml.MappingNode):
        return HassilNotation(text.text(node)).parse()
    parts = text.mapping(node, "in and out")
    if "in" not in parts:
        raise error_at(text.place(node), '"in" is missing; add what is said')
    spoken = HassilNotation(text.text(parts["in"])).parse()
    return Tag(spoken, parse_value(text.text(parts["out"]).text)) if "out" in parts else spoken


def _range(text: Yaml, node: yaml.Node, place: Location) -> NumberRange:
    parts = {name: text.text(value).text for name, value in text.mapping(node, "from, to").items()}
    try:
        first, last = Fraction(parts["from"]), Fraction(parts["to"])
        step = Fraction(parts.get("step", FRACTIONS[parts.get("fractions", "none")]))
        factor = Fraction(parts.get("multiplier", "1"))
    except (KeyError, ValueError, ZeroDivisionError):
        raise error_at(
            place,
            "invalid range; write it as from: 0, to: 100, step: 5, or with fractions: halves "
            "or tenths, and multiplier: 2",
        ) from None
    return check_range(NumberRange(first, last, step, factor), place)


FRACTIONS = {"none": "1", "halves": "1/2", "tenths": "1/10"}
"""The steps of a range by what hassil calls them."""

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


RHINO_ADVICE = Advice(
    rule='macros: {NAME: ["would you", please]}',
    list="slots: {NAME: [red, green]}",
    sentence="write expressions",
)


def parse_rhino(text: Yaml) -> TemplateSource:
    """Parse a YAML context of Rhino; raises CommandsError."""
    source = TemplateSource(text.name, lenient=True, advice=RHINO_ADVICE)
    source.warnings += text.warnings
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
