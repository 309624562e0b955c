"""Spelling: normalized words, what nobody can speak, typed text as spoken words; pure."""

from __future__ import annotations

import re
import unicodedata
from fractions import Fraction

from voz.language.sentences.number_words import wordings

MAX_WORD_LETTERS = 40  # the longest English words have under 30; festival crashes on 3000

COMBINING_SIGN = r"(?:(?!\w)[\u0300-\u036f\u0900-\u0963\u0971-\u0d65])"
"""Vowel signs and accents that belong to a letter."""

ANY_LETTER = rf"(?:[^\W\d_]|{COMBINING_SIGN})"
"""A letter of any language."""

# Of the white space only the space and the tab are meant to be in a line of text: the others
# that `\s` knows below U+0020 are control characters.
_UNUSUAL = re.compile(r"[^a-zA-Z'\s]|[\x0b\x0c\x1c-\x1f\x85]")


def normalize(text: str) -> str:
    """Convert to lower case with single spaces, and accented letters to one character each."""
    return " ".join(compose_accents(text.lower()).split())


def compose_accents(text: str) -> str:
    """Write each letter with its accent as one character."""
    return unicodedata.normalize("NFC", text)


def strip_accents(text: str) -> str:
    """Remove all accents, as typed on a keyboard without them."""
    letters = unicodedata.normalize("NFD", text)
    return "".join(letter for letter in letters if not unicodedata.combining(letter))


def find_unspeakable(text: str) -> tuple[int, str] | None:
    """Find the first character that cannot stand in a command: its offset, and advice."""
    for found in _UNUSUAL.finditer(text):
        if unicodedata.category(found.group())[0] not in "LM":  # letters, and signs put to them
            return found.start(), _advice(found.group())
    return None


def length_complaint(word: str) -> str:
    """Explain why a word is too long; empty if it is not."""
    if len(word) <= MAX_WORD_LETTERS:
        return ""
    return (
        f'"{word[:MAX_WORD_LETTERS]}..." has {len(word)} letters, '
        f"more than {MAX_WORD_LETTERS}; write it as several words"
    )


def _advice(char: str) -> str:
    shown = f'"{char}"' if char.isprintable() else f"the character U+{ord(char):04X}"
    if char.isnumeric():
        return f"{shown} is a digit; write the number as words"
    if unicodedata.category(char) == "Pd":
        return f"{shown} cannot be spoken; write a space instead"
    if char in "‘’`´":  # noqa: RUF001 (what editors and keyboards make of an apostrophe)
        return f"{shown} cannot be spoken; write a plain apostrophe (') instead"
    return f"{shown} cannot be spoken; remove it"


_LETTERS = rf"(?:[^\W_]|{COMBINING_SIGN})+"
_TOKEN = re.compile(r"(?a:[-+]?[0-9]+(?:\.[0-9]+)?|\.[0-9]+)|" rf"{_LETTERS}(?:'{_LETTERS})*'?")
_PLAIN = str.maketrans(
    {**dict.fromkeys("‘’`´", "'"), "°": " degrees ", "%": " percent "}  # noqa: RUF001
)
"""Variants of an apostrophe, and signs that are words."""

_HYPHEN = re.compile(r"(?<=\w)-|-(?!\.?[0-9])")


def spoken_forms(text: str) -> list[list[str]]:
    """Return the ways to say each word or number of typed text."""
    plain = _HYPHEN.sub(" ", compose_accents(text.lower()).translate(_PLAIN))
    return [_said(token) for token in _TOKEN.findall(plain)]


def plain_form(text: str) -> str:
    """Return text in its first wording and without accents: forms of one text are the same."""
    return strip_accents(" ".join(ways[0] for ways in spoken_forms(text)))


def _said(token: str) -> list[str]:
    try:
        return list(wordings(Fraction(token)))
    except ValueError:  # no number, or too large to be said
        return [token]
