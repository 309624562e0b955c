"""The command list: parse it, normalize it, refuse what cannot be spoken. Does no I/O."""

from __future__ import annotations

import codecs
import re
import unicodedata
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from voz.errors import CommandsError

MAX_BYTES = 1_000_000
MAX_WORDS = 12
MAX_LETTERS = 40  # the longest English words have under 30; festival crashes on 3000
MAX_WARNINGS = 10

SIGN = r"(?:(?!\w)[\u0300-\u036f\u0900-\u0963\u0971-\u0d65])"
"""What some scripts put to a letter, and is none by itself."""

LETTER = rf"(?:[^\W\d_]|{SIGN})"
"""Of any language; which of them a language has, its dictionary says."""

# Of the white space only the space and the tab are meant to be in a line of text: the others
# that `\s` knows below U+0020 are control characters.
_UNUSUAL = re.compile(r"[^a-zA-Z'\s]|[\x0b\x0c\x1c-\x1f\x85]")
_NOT_ENGLISH = re.compile(r"[^a-z']")


@dataclass(frozen=True)
class CommandList:
    """A command list that can be used.

    Attributes:
        name: what messages call the list, mostly its path.
        sentences: the commands, normalized, each once, in the order of the list.
        lines: the line in which each sentence stands, counted from 1.
        warnings: what the user should know, one line each.
    """

    name: str
    sentences: tuple[str, ...]
    lines: tuple[int, ...]
    warnings: tuple[str, ...] = ()

    def places(self) -> dict[str, str]:
        """Give each word of the commands and where it first stands, as `FILE:LINE`."""
        places: dict[str, str] = {}
        for sentence, line in zip(self.sentences, self.lines, strict=True):
            for word in sentence.split():
                if word not in places:
                    places[word] = f"{self.name}:{line}"
        return places


def normalize(text: str) -> str:
    """Bring a command, from a list or typed, into the one form that all parts compare.

    Returns:
        The text in lower case, with single spaces and none at its ends; a letter with its accent
        is one character.
    """
    return " ".join(composed(text.lower()).split())


def composed(text: str) -> str:
    """Write each letter with its accent as one character, whatever the editor made of it."""
    return unicodedata.normalize("NFC", text)


def without_accents(text: str) -> str:
    """Leave out all accents, as who types on a keyboard without them does."""
    letters = unicodedata.normalize("NFD", text)
    return "".join(letter for letter in letters if not unicodedata.combining(letter))


def parse_commands(data: bytes, name: str) -> CommandList:
    """Parse a command list: one sentence a line, `#` begins a comment.

    Args:
        data: the bytes of the list, UTF-8.
        name: what messages call the list.

    Raises:
        CommandsError: the list cannot be used; the message says which line and why.
    """
    lines: dict[str, int] = {}
    repeats: list[str] = []
    for number, text in text_lines(data, name):
        _check_sentence(text, f"{name}:{number}")
        sentence = normalize(text)
        first = lines.setdefault(sentence, number)
        if first != number:
            repeats.append(
                f'{name}:{number}: "{sentence}" is there twice (first in line {first}); kept once'
            )
    if not lines:
        raise CommandsError(f"{name}: holds no command; write one sentence a line")
    summary = f"{name}: {len(repeats)} lines repeat an earlier one; each sentence is kept once"
    return CommandList(name, tuple(lines), tuple(lines.values()), at_most(repeats, summary))


def text_lines(data: bytes, name: str) -> Iterator[tuple[int, str]]:
    """Go through the lines of a text that hold more than a comment.

    Args:
        data: the bytes of the text; any line ends, with or without a byte order mark.
        name: what messages call the text.

    Yields:
        The number of the line, counted from 1, and the line without its comment and outer space.

    Raises:
        CommandsError: the text is too large or a line is not UTF-8.
    """
    for number, line in whole_lines(data, name):
        text = line.partition("#")[0].strip(" \t")
        if text.strip():
            yield number, text


def whole_lines(data: bytes, name: str) -> Iterator[tuple[int, str]]:
    """Go through all lines of a text as they are; the rest is as with `text_lines`."""
    if len(data) > MAX_BYTES:
        raise CommandsError(f"{name}: is larger than {MAX_BYTES:,} bytes; make it smaller")
    data = data.removeprefix(codecs.BOM_UTF8).replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    for number, line in enumerate(data.split(b"\n"), start=1):
        try:
            yield number, line.decode("utf-8")
        except UnicodeDecodeError:
            raise CommandsError(
                f"{name}:{number}: is not UTF-8 text; save the file as UTF-8"
            ) from None


def at_most(warnings: list[str], summary: str) -> tuple[str, ...]:
    """Keep a few warnings as they are, and replace many by one that sums them up."""
    return tuple(warnings) if len(warnings) <= MAX_WARNINGS else (summary,)


def _check_sentence(text: str, where: str) -> None:
    """Raise CommandsError, beginning with `where`, if the text is no usable sentence."""
    if found := what_cannot_be_spoken(text):
        raise CommandsError(f"{where}: {found[1]}")
    words = text.split()
    if len(words) > MAX_WORDS:
        raise CommandsError(
            f"{where}: has {len(words)} words, more than {MAX_WORDS}; make the command shorter"
        )
    if advice := too_long(max(words, key=len)):
        raise CommandsError(f"{where}: {advice}")


def what_cannot_be_spoken(text: str) -> tuple[int, str] | None:
    """Find the first character that cannot stand in a command: where, and what to do about it."""
    for found in _UNUSUAL.finditer(text):
        if unicodedata.category(found.group())[0] not in "LM":  # letters, and signs put to them
            return found.start(), _advice(found.group())
    return None


def check_english(places: Mapping[str, str]) -> None:
    """Refuse words with letters that English does not have.

    Args:
        places: the words, and where each stands for messages.

    Raises:
        CommandsError: there is one.
    """
    for word, place in places.items():
        if wrong := _NOT_ENGLISH.search(word):
            raise CommandsError(
                f'{place}: "{wrong.group()}" is not one of the letters a to z; write the word with '
                "plain letters and its pronunciation in pronunciations.txt, or set [language]"
            )


def too_long(word: str) -> str:
    """Say that a word is too long to be one; empty if it is not."""
    if len(word) <= MAX_LETTERS:
        return ""
    return (
        f'"{word[:MAX_LETTERS]}..." has {len(word)} letters, '
        f"more than {MAX_LETTERS}; write it as several words"
    )


def _advice(char: str) -> str:
    """Say why a character cannot stand in a command, and what to write instead."""
    shown = f'"{char}"' if char.isprintable() else f"the character U+{ord(char):04X}"
    if char.isnumeric():
        return f"{shown} is a digit; write the number as words"
    if unicodedata.category(char) == "Pd":
        return f"{shown} cannot be spoken; write a space instead"
    if char in "‘’`´":  # noqa: RUF001 (what editors and keyboards make of an apostrophe)
        return f"{shown} cannot be spoken; write a plain apostrophe (') instead"
    return f"{shown} cannot be spoken; remove it"
