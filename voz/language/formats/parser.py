"""The parser of words, groups and alternatives, which all notations share; pure."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import ClassVar, NamedTuple, NoReturn

from voz.language.sentences.expression import (
    NO_WORDS,
    Choice,
    Expression,
    NumberRange,
    Optional,
    Permutation,
    Word,
    choice,
    concatenation,
    phrase,
)
from voz.language.sentences.spelling import find_unspeakable, length_complaint, spoken_forms
from voz.language.sentences.text_lines import Passage, error_at

MAX_GROUP_DEPTH = 40
"""Nested groups; Python's own recursion limit is not far above."""

MAX_PERMUTED_PARTS = 5
"""Six parts have 720 orders."""


_NUMBER = re.compile(r"-?[0-9]{1,6}(\.[0-9]{1,6})?", re.ASCII)


class Token(NamedTuple):
    """A word or a mark, its offset, and whether there is space before it."""

    kind: str
    text: str
    at: int
    spaced: bool


class Parser:
    """Parses one expression; subclasses override what differs."""

    TOKEN: ClassVar[re.Pattern[str]]
    """Has a named group for each kind of token; other characters are space."""

    PARTS: ClassVar[str] = "|"
    """Separators of alternatives; `;` means in any order."""

    EMPTY: ClassVar[bool] = False
    """Whether an alternative may have no word."""

    OPTIONAL: ClassVar[tuple[str, str]] = ("[", "]")
    GROUP: ClassVar[tuple[str, str]] = ("(", ")")

    def __init__(self, passage: Passage) -> None:
        """Split a passage into tokens."""
        self.passage = passage
        self.tokens = self._split()
        self.at = 0
        self.depth = 0

    def parse(self) -> Expression:
        """Parse all of it; raises CommandsError."""
        found = self.alternatives("")
        token = self.tokens[self.at]
        if token.kind != "end":
            self.fail(f'unmatched "{token.text}"', token.at)
        return found

    @property
    def next(self) -> Token:
        """The next token, which is not taken."""
        return self.tokens[self.at]

    def take(self) -> Token:
        """Take the next token."""
        self.at += 1
        return self.tokens[self.at - 1]

    def fail(self, message: str, at: int) -> NoReturn:
        """Raise an error about a place in the passage."""
        raise error_at(self.passage.place(at), message)

    def alternatives(self, opened: str) -> Expression:
        """Parse what is in a group, or all; `opened` is the mark that opened the group."""
        parts, between = [self.alternative()], ""
        while self.next.text in self.PARTS and self.next.kind == "mark":
            token = self.take()
            if token.text == ";" and not opened:
                self.fail('";" (in any order) is allowed only in groups, as in (a;b)', token.at)
            if between and token.text != between:
                self.fail(f'"{between}" and "{token.text}" are mixed; use parentheses', token.at)
            between = token.text
            parts.append(self.alternative())
        if between == ";":
            if len(parts) > MAX_PERMUTED_PARTS:
                self.fail(
                    f"{len(parts)} parts in any order; at most {MAX_PERMUTED_PARTS} are allowed",
                    self.next.at,
                )
            return Permutation(tuple(parts))
        return choice(parts)

    def alternative(self) -> Expression:
        """Parse a sequence, which has at least one item."""
        items: list[Expression] = []
        begin = self.next.at
        while not (self.next.kind == "end" or self.ends()):
            self.item(items)
        if not items and not self.EMPTY:
            self.fail('empty alternative; write "[...]" around optional words', begin)
        return concatenation(items)

    def ends(self) -> bool:
        """Whether the next token ends an alternative."""
        closing = (self.OPTIONAL[1], self.GROUP[1])
        return self.next.kind == "mark" and (self.next.text in (*closing, *self.PARTS))

    def item(self, items: list[Expression]) -> None:
        """Parse one more item of a sequence."""
        items.append(self.atom())

    def atom(self) -> Expression:
        """Parse a word or a group."""
        token = self.take()
        if token.kind == "word":
            return self.word(token)
        if token.kind == "mark" and token.text in (self.OPTIONAL[0], self.GROUP[0]):
            return self.group(token)
        return self.other(token)

    def other(self, token: Token) -> Expression:
        """Parse what only some notations have."""
        if token.kind == "mark" and token.text in "<{":
            close = {"<": ">", "{": "}"}[token.text]
            self.fail(f'"{token.text}" is not closed; add "{close}" after the name', token.at)
        return self.fail(f'"{token.text}" is not allowed here; remove it', token.at)

    def group(self, token: Token) -> Expression:
        """Parse a group after its opening mark."""
        close = dict((self.OPTIONAL, self.GROUP))[token.text]
        self.depth += 1
        if self.depth > MAX_GROUP_DEPTH:
            self.fail("groups are nested too deeply; use rules", token.at)
        inner = self.alternatives(token.text)
        if self.next.text != close or self.next.kind != "mark":
            self.fail(f'"{token.text}" is not closed; write "{close}"', token.at)
        self.take()
        self.depth -= 1
        return Optional(inner) if token.text == self.OPTIONAL[0] else inner

    def word(self, token: Token) -> Expression:
        """Return how what is written without a space is said; raises CommandsError."""
        if found := find_unspeakable(token.text):
            self.fail(found[1], token.at + found[0])
        each = spoken_forms(token.text)
        for way in (ways[0] for ways in each):
            if any(map(str.isdigit, way)):
                self.fail(f"{way} is no number that voz can say; write it as words", token.at)
            if advice := length_complaint(way):
                self.fail(advice, token.at)
        if number := _NUMBER.fullmatch(token.text):
            return NumberRange(Fraction(number[0]), Fraction(number[0]), Fraction(1))
        return concatenation(
            [choice([phrase(way) for way in ways], synonyms=True) for ways in each]
        )

    def _split(self) -> list[Token]:
        text, end = self.passage.text, 0
        found: list[Token] = []
        for match in self.TOKEN.finditer(text):
            if match.lastgroup:
                spaced = match.start() > end or not found
                found.append(Token(match.lastgroup, match.group(), match.start(), spaced))
                end = match.end()
        return [*found, Token("end", "", len(text.rstrip()), True)]


class Spelling(NamedTuple):
    """A spelling of a word, and the one without what may be left out."""

    usual: str
    written: str


def word_spellings(item: Expression) -> list[Spelling] | None:
    """Return all spellings of a group of single words; None if it is something else."""
    if isinstance(item, Word):
        return [Spelling(item.text, item.text)]
    if item == NO_WORDS:
        return [Spelling("", "")]
    if isinstance(item, Optional):
        inner = word_spellings(item.item)
        return (
            None if inner is None else [Spelling("", ""), *(Spelling("", s.written) for s in inner)]
        )
    if isinstance(item, Choice):
        each = [word_spellings(one) for one in item.items]
        return None if None in each else [one for found in each for one in found or ()]
    return None
