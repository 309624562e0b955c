"""The notation of voz, which is that of hassil and Home Assistant, and files in it; pure."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from itertools import product

from voz.language.formats.parser import Parser, Token, word_spellings
from voz.language.sentences.expression import (
    Expression,
    NumberRange,
    Reference,
    Slot,
    Tag,
    Word,
    check_range,
    choice,
    parse_value,
)
from voz.language.sentences.spelling import MAX_WORD_LETTERS, compose_accents, normalize
from voz.language.sentences.templates import Template, TemplateSource
from voz.language.sentences.text_lines import Faults, Location, Passage, error_at, numbered_lines

NAME_PATTERN = r"[^\W\d][\w-]*"
"""Of a rule, a list or a slot."""

MAX_JOINED_WORDS = 100
"""Spellings of `light[s]` and the like."""

_NUMBER = r"[-+]?(?:[0-9]{1,9}(?:\.[0-9]{1,9})?|\.[0-9]{1,9})"
_RANGE = re.compile(
    rf"\s*({_NUMBER})\s*\.\.\s*({_NUMBER})(?:\s*(?:by|,|/|\s)\s*({_NUMBER}))?\s*", re.ASCII
)
_NUMBERED_SLOT = re.compile(rf"(.*\.\..*):\s*({NAME_PATTERN})\s*", re.DOTALL)
_SEPARATORS = re.compile(r"[(\[][\s|_'-]+[)\]]")
"""What stands between words, as in `{minutes}( |-)minute` of hassil."""

_SLOT = re.compile(rf"\s*({NAME_PATTERN})\s*(?::(.*))?", re.DOTALL)
_NAME = re.compile(rf"\s*({NAME_PATTERN})\s*")


class Notation(Parser):
    """Parses an expression of voz's notation."""

    TOKEN = re.compile(
        r"(?P<slot>\{[^{}]*\})|(?P<rule><[^<>]*>)|(?P<value>:[^|()\[\]{}<>;]*)"
        r"|(?P<mark>[()\[\]{}<>|;])|(?P<word>[^\s()\[\]{}<>|;:]+)"
    )
    PARTS = "|;"

    def __init__(self, passage: Passage, values: bool = False) -> None:
        """Split a passage; `values` allows values, as in a list."""
        text = _SEPARATORS.sub(lambda found: " " * len(found.group()), passage.text)
        super().__init__(replace(passage, text=text, whole=passage.whole or passage.text))
        self.values = values

    def alternative(self) -> Expression:
        """Parse a sequence, in a list with its value."""
        found = super().alternative()
        if self.next.kind != "value":
            return found
        token = self.take()
        if not self.values:
            self.fail('":" gives values in lists only, as in: color = deep blue:blue', token.at)
        if not token.text[1:].strip():
            self.fail('no value after ":"; add one or remove the ":"', token.at)
        return Tag(found, parse_value(" ".join(token.text[1:].split())))

    def ends(self) -> bool:
        """Whether the next token ends an alternative; a value does."""
        return super().ends() or self.next.kind == "value"

    def item(self, items: list[Expression]) -> None:
        """Parse one more item; a group that touches a word is part of it, as in `light[s]`."""
        at = self.at
        item = self.atom()
        if items and self._touches(at):
            items[-1] = self._joined(items[-1], item, self.tokens[at])
        else:
            items.append(item)

    def _touches(self, at: int) -> bool:
        """Whether a group and a word have no space between them, nor just inside the group."""
        before, token, after = self.tokens[at - 1 : at + 2]
        if token.spaced:
            return False
        if token.kind == "word":
            ends = before.kind in ("slot", "rule") or (before.kind == "mark" and not before.spaced)
            return ends and _is_of_word(token.text[0])
        letters = token.kind == "mark" and not after.spaced
        letters = letters and (after.kind != "word" or _is_of_word(after.text[0]))
        named = token.kind in ("slot", "rule")
        return before.kind == "word" and _is_of_word(before.text[-1]) and (letters or named)

    def _joined(self, first: Expression, second: Expression, token: Token) -> Expression:
        one, other = word_spellings(first), word_spellings(second)
        if one is None or other is None or len(one) * len(other) > MAX_JOINED_WORDS:
            self.fail("only letters may touch a word, as in light[s]; add a space", token.at)
        words: dict[str, dict[Expression, None]] = {}  # with their spellings, the usual one first
        for begin, end in product(one, other):
            usual, word = normalize(begin.usual + end.usual), normalize(begin.written + end.written)
            if len(word) > MAX_WORD_LETTERS or not word:
                self.fail("this is not a word; add a space", token.at)
            words.setdefault(usual, {})[Word(word)] = None
        return choice([choice([*spellings], synonyms=True) for spellings in words.values()])

    def other(self, token: Token) -> Expression:
        """Parse a slot or a rule."""
        if token.kind == "slot":
            return slot(self.passage.part(token.at + 1, token.at + len(token.text) - 1))
        if token.kind == "rule":
            match = _NAME.fullmatch(token.text[1:-1])
            if not match:
                self.fail("the name of a rule is one word, as in <polite>", token.at)
            return Reference("rule", match[1], self.passage.place(token.at))
        if token.kind == "value":
            self.fail('":" is allowed only after the name of a template, and in lists', token.at)
        return super().other(token)


def slot(passage: Passage) -> Slot:
    """Parse the inside of braces: `color`, `thing:object` or `angle: 5..180 by 5`."""
    place = passage.place()
    numbered = _NUMBERED_SLOT.fullmatch(passage.text)
    if numbered and (numbers := number_range(numbered[1], place)):
        return Slot(numbered[2], numbers, place)
    match = _SLOT.fullmatch(passage.text)
    if not match:
        raise error_at(place, "the name of a slot is one word, as in {color}")
    name, behind = match[1], match[2]
    if behind is None:
        return Slot(name, Reference("list", name, place), place)
    if other := _NAME.fullmatch(behind):
        return Slot(other[1], Reference("list", name, place), place)
    if numbers := number_range(behind, passage.place(match.start(2))):
        return Slot(name, numbers, place)
    raise error_at(
        passage.place(match.start(2)),
        "expected a name, as in {thing:object}, or numbers, as in {angle: 5..180 by 5}",
    )


def list_body(passage: Passage) -> Expression:
    """Parse the body of a list: alternatives with values, or a range. Raises CommandsError."""
    return number_range(passage.text, passage.place()) or Notation(passage, values=True).parse()


def number_range(text: str, place: Location) -> NumberRange | None:
    """Parse a range such as `5..180 by 5`; None if it is none. Raises CommandsError."""
    match = _RANGE.fullmatch(text)
    if not match:
        return None
    first, last, step = (Fraction(number or "1") for number in match.groups())
    return check_range(NumberRange(first, last, step), place)


def _is_of_word(char: str) -> bool:
    """Whether a character is a part of a word; `%` is a word of its own, and `-` stands between."""
    return char.isalpha() or char in "'‘’`´"  # noqa: RUF001 (what keyboards make of an apostrophe)


_MARKS = re.compile(rb"[()\[\]{}<>|;:=0-9]")  # a number is said in several ways
_IMPORT = re.compile(r"\s*import\s+(\S*[./\\]\S*)\s*", re.IGNORECASE)
_TEMPLATE_RULE = re.compile(rf"\s*<({NAME_PATTERN})>\s*=")
_LIST = re.compile(rf"\s*({NAME_PATTERN})\s*=")
_COMMAND = re.compile(r"\s*([^\W\d][\w'-]*(?:[ \t]+[\w'-]+)*)\s*:")


def has_templates(data: bytes) -> bool:
    """Whether a command list has more than plain sentences; comments do not count."""
    lines = (line.partition(b"#")[0] for line in data.replace(b"\r", b"\n").split(b"\n"))
    return any(_MARKS.search(line) or _is_import(line) for line in lines)


def _is_import(line: bytes) -> bool:
    return bool(_IMPORT.fullmatch(line.decode("utf-8", "replace").strip("\ufeff")))


def parse_templates(data: bytes, name: str) -> TemplateSource:
    """Parse a file in voz's notation, UTF-8; `name` is for messages. Raises CommandsError."""
    source, faults = TemplateSource(name), Faults()
    for number, whole in numbered_lines(data, name):
        text = whole.partition("#")[0].rstrip()
        if text.strip():
            with faults:
                _add(source, Passage(name, number, 0, text))
    faults.check()
    return source


def _add(source: TemplateSource, line: Passage) -> None:
    place = line.place(len(line.text) - len(line.text.lstrip()))
    if match := _IMPORT.fullmatch(line.text):
        source.imports.append((match[1], line.place(match.start(1))))
    elif match := _TEMPLATE_RULE.match(line.text):
        body = Notation(_behind(line, match)).parse()
        source.define("rule", match[1], body, place)
    elif match := _LIST.match(line.text):
        source.define("list", match[1], list_body(_behind(line, match)), place)
    elif match := _COMMAND.match(line.text):
        expression = Notation(_behind(line, match)).parse()
        source.templates.append(
            Template(compose_accents(" ".join(match[1].split())), expression, place)
        )
    elif "=" in line.text:
        at = line.text.index("=")
        raise error_at(
            line.place(at),
            '"=" is allowed only after the name of a list or rule, as in: color = red | green',
        )
    else:
        source.templates.append(Template(None, Notation(line).parse(), place))


def _behind(line: Passage, match: re.Match[str]) -> Passage:
    if not line.text[match.end() :].strip():
        raise error_at(line.place(match.end() - 1), "nothing follows; write what is said")
    return line.part(match.end())
