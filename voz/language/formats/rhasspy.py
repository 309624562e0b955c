"""Rhasspy's `sentences.ini`; pure.

`[Intent]` begins the sentences of one, `name = ...` is a rule of it, `<Intent.name>` of another,
`word:other` says what counts for a word, `(red | green){color}` is a slot, `$name` a list in
`slots/name` beside the file.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction

from voz.language.formats.parser import Parser, Token
from voz.language.sentences.expression import (
    NO_WORDS,
    Choice,
    DefinitionKey,
    Expression,
    NumberRange,
    Optional,
    Reference,
    Slot,
    Tag,
    Value,
    check_range,
    choice,
    parse_value,
    plain_words,
    references,
    renamed,
    with_children,
)
from voz.language.sentences.templates import Advice, Template, TemplateSource
from voz.language.sentences.text_lines import Faults, Location, Passage, error_at, numbered_lines

_INTENT = re.compile(r"\s*\[([^\[\]|()]+)\]\s*")
_RHASSPY_RULE = re.compile(r"\s*([\w-]+)\s*=")
_TAG = re.compile(r"\{\s*([A-Za-z_][\w-]*)\s*(?::([^{}!]*))?((?:!\w+)*)\s*\}")
_RANGE = re.compile(r"(-?[0-9]{1,6})\.\.(-?[0-9]{1,6})(?:,([0-9]{1,6}))?", re.ASCII)

ReadSlots = Callable[[str], tuple[str, bytes] | None]
"""Reads a list: what messages call its file, and its bytes; None if there is none."""


TRUTHS: Mapping[str, bool] = {
    **dict.fromkeys(("true", "yes", "on", "1"), True),
    **dict.fromkeys(("false", "no", "off", "0"), False),
}

CONVERTERS: Mapping[str, Callable[[Value], Value]] = {
    "int": lambda value: int(float(value)),
    "float": float,
    "bool": lambda value: TRUTHS[str(value).lower()],
    "upper": lambda value: str(value).upper(),
    "lower": lambda value: str(value).lower(),
}
"""What `!` and a name behind words or a value makes of it."""

RHASSPY_ADVICE = Advice(
    rule="NAME = (would you | please)",
    list="slots/NAME",
    sentence="write [Intent] and its sentences",
)


class RhasspyParser(Parser):
    """Parses a template of Rhasspy."""

    TOKEN = re.compile(
        r"(?P<tag>\{[^{}]*\})|(?P<rule><[^<>]*>)|(?P<list>\$[\w/.-]+)"
        r"|(?P<value>:(?:\([^()]*\)|[^\s()\[\]{}<>|!]*))|(?P<converter>!\w+)"
        r"|(?P<mark>[()\[\]{}<>|])|(?P<word>[^\s()\[\]{}<>|:!$]+)"
    )

    def item(self, items: list[Expression]) -> None:
        """Parse one more item; values, converters and tags apply to the one before it."""
        token = self.next
        if token.kind == "value":
            self.take()
            item = items.pop() if items and not token.spaced else NO_WORDS
            items.append(self._substituted(item, token))
        elif token.kind == "tag":
            if not items:
                self.fail("no words before this tag; write it as in (red){color}", token.at)
            self.take()
            items.append(self._slot(items.pop(), token))
        elif token.kind == "converter":
            if not items or token.spaced:
                self.fail("no words before this converter; write it as in half:30!int", token.at)
            items.append(self._converted(items.pop(), self.take().text[1:], token.at))
        else:
            items.append(self.atom())

    def _substituted(self, item: Expression, token: Token) -> Expression:
        """Return words with the value that counts for them, as in `half:30` or `half:(30!int)`."""
        value, *converters = token.text.strip(":()").split("!")
        item = Tag(item, parse_value(" ".join(value.split())))
        for converter in converters:
            item = self._converted(item, converter.strip(), token.at)
        return item

    def _slot(self, item: Expression, token: Token) -> Slot:
        match = _TAG.fullmatch(token.text)
        if not match:
            self.fail("a tag is one word, optionally with a value, as in {color:red}", token.at)
        name, value, converters = match.groups()
        if value is not None:
            item = Tag(item, parse_value(value.strip()))
        for converter in converters.split("!")[1:]:
            item = self._converted(item, converter, token.at)
        return Slot(name, item, self.passage.place(token.at))

    def _converted(self, item: Expression, converter: str, at: int) -> Expression:
        """Return what is said with its value converted."""
        if converter not in CONVERTERS:
            known = ", ".join(CONVERTERS)
            self.fail(f"there is no converter {converter}; the converters are {known}", at)
        return _convert(item, converter, self.passage.place(at))

    def word(self, token: Token) -> Expression:
        """Check a word; it may be a range of numbers."""
        if match := _RANGE.fullmatch(token.text):
            first, last, step = (Fraction(number or "1") for number in match.groups())
            return check_range(NumberRange(first, last, step), self.passage.place(token.at))
        return super().word(token)

    def other(self, token: Token) -> Expression:
        """Parse a rule or a list."""
        place = self.passage.place(token.at)
        if token.kind == "rule":
            return Reference("rule", token.text[1:-1].strip(), place)
        if token.kind == "list":
            return Reference("list", token.text[1:], place)
        return super().other(token)


def _convert(item: Expression, converter: str, place: Location) -> Expression:
    """Return what is said with its value converted; of a rule or list one of another name."""
    if isinstance(item, Choice | Optional):
        return with_children(item, lambda one: _convert(one, converter, place))
    if isinstance(item, Reference):
        return replace(item, name=f"{item.name}!{converter}")
    if isinstance(item, Tag):
        said, value = item.item, item.value
    elif (text := plain_words(item)) is not None:
        said, value = item, text
    else:  # a range has its numbers as such
        return item
    try:
        converted = CONVERTERS[converter](value)
    except (ValueError, OverflowError, KeyError):
        converted = math.nan
    if isinstance(converted, float) and not math.isfinite(converted):
        raise error_at(place, f'"{value}" cannot be converted by !{converter}; write another value')
    return Tag(said, converted)


def parse_rhasspy(data: bytes, name: str, read_slots: ReadSlots) -> TemplateSource:
    """Parse a `sentences.ini`, UTF-8, which messages call `name`; raises CommandsError."""
    source, faults = TemplateSource(name, lenient=True, advice=RHASSPY_ADVICE), Faults()
    intent = ""
    own: dict[str, dict[DefinitionKey, str]] = {}
    for number, line in numbered_lines(data, name):
        text = line.partition("#")[0].rstrip()
        if not text.strip() or text.lstrip().startswith(";"):
            continue
        if match := _INTENT.fullmatch(text):
            intent = match[1].strip()
            continue
        passage = Passage(name, number, 0, text)
        if not intent:
            raise error_at(passage.place(), "no [Intent] before this line; add one")
        with faults:
            _add(source, intent, passage, own.setdefault(intent, {}))
    faults.check()
    _use_names(source, own)
    _add_named(source, read_slots)
    return source


def _add(source: TemplateSource, intent: str, line: Passage, own: dict[DefinitionKey, str]) -> None:
    if match := _RHASSPY_RULE.match(line.text):
        for form in ("", *(f"!{converter}" for converter in CONVERTERS)):
            own["rule", match[1] + form] = f"{intent}.{match[1]}{form}"
        body = RhasspyParser(line.part(match.end())).parse()
        source.define("rule", f"{intent}.{match[1]}", body, line.place())
        return
    begin = len(line.text) - len(line.text.lstrip())
    if line.text.startswith("\\[", begin):  # a sentence that begins with an option
        begin += 1
    expression = RhasspyParser(line.part(begin)).parse()
    source.templates.append(Template(intent, expression, line.place(begin)))


def _use_names(source: TemplateSource, own: dict[str, dict[DefinitionKey, str]]) -> None:
    """Replace the names of an intent's own rules by their global names."""
    source.templates = [
        Template(t.command, renamed(t.expression, own.get(t.command or "", {})), t.place)
        for t in source.templates
    ]
    for (kind, name), definition in list(source.definitions.items()):
        names = own.get(name.rpartition(".")[0], {})
        body = renamed(definition.expression, names)
        source.definitions[kind, name] = type(definition)(body, definition.place)


def _add_named(source: TemplateSource, read_slots: ReadSlots) -> None:
    """Read the lists that are named, and convert lists and rules; a list may name others."""
    todo = [template.expression for template in source.templates]
    todo += [definition.expression for definition in source.definitions.values()]
    converted, used = set(), set()
    for expression in todo:
        for found in references(expression):
            used.add((found.kind, found.name))
            if (found.kind, found.name) in source.definitions:
                continue
            name, *converters = found.name.split("!")
            if found.kind == "list":
                values, place = _list(replace(found, name=name), read_slots)
            elif converters and (rule := source.definitions.get(("rule", name))):
                values, place = rule.expression, rule.place
                converted.add((found.kind, name))
            else:
                continue
            for converter in converters:
                values = _convert(values, converter, found.place)
            source.define(found.kind, found.name, values, place)
            todo.append(values)
    for key in converted - used:
        del source.definitions[key]


def _list(named: Reference, read_slots: ReadSlots) -> tuple[Expression, Location]:
    read = read_slots(named.name)
    if read is None:
        raise error_at(
            named.place,
            f'there is no list "${named.name}"; write its values, one per line, into '
            f"slots/{named.name} beside this one",
        )
    file, data = read
    lines = [
        Passage(file, number, 0, line)
        for number, whole in numbered_lines(data, file)
        if (line := whole.partition("#")[0].rstrip())
    ]
    if not lines:
        raise error_at(named.place, f"{file} is empty; write one value per line")
    return choice([RhasspyParser(line).parse() for line in lines]), lines[0].place()
