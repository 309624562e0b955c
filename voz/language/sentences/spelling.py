"""Spelling: normalized words, what nobody can speak, typed text as spoken words; pure."""

from __future__ import annotations

import re
import unicodedata
from fractions import Fraction

from voz.language.sentences.number_words import ENGLISH, wordings

MAX_WORD_LETTERS = 40  # the longest English words have under 30; festival crashes on 3000

COMBINING_SIGN = r"(?:(?!\w)[\u0300-\u036f\u0900-\u0963\u0971-\u0d65])"
"""Vowel signs and accents that belong to a letter."""

ANY_LETTER = rf"(?:[^\W\d_]|{COMBINING_SIGN})"
"""A letter of any language."""

NOT_SPOKEN = ".,/;:!?…¿¡\"'‘’`´“”„«»()[]"  # noqa: RUF001 (what keyboards make of an apostrophe)
"""Marks between words, and apostrophes."""

SIGNS = {"%": "percent", "°": "degrees", "&": "and"}
"""Signs that are words."""


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
    """Find the first character that nobody can say: its offset, and advice."""
    for at, char in enumerate(text):
        if not _can_be_spoken(char):
            return at, _advice(char)
    return None


def _can_be_spoken(char: str) -> bool:
    """Whether a character is spoken, or stands between words."""
    if char.isascii():
        return char.isalnum() or char in " \t\n-_" or char in NOT_SPOKEN or char in SIGNS
    kind = unicodedata.category(char)  # letters, signs put to them, white space, dashes
    return kind[0] in "LM" or kind in ("Zs", "Pd") or char in NOT_SPOKEN or char in SIGNS


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
        return f"{shown} is a digit; write the number as words, or as 0 to 9"
    return f"{shown} cannot be spoken; remove it"


_LETTERS = rf"(?:[^\W\d_]|{COMBINING_SIGN})+"
_TOKEN = re.compile(
    r"(?a:[0-9]+/[1-9][0-9]*|[-+]?[0-9]+(?:\.[0-9]+)?|\.[0-9]+)|" rf"{_LETTERS}(?:'{_LETTERS})*'?"
)
_PLAIN = str.maketrans(
    {**dict.fromkeys("‘’`´", "'"), **{sign: f" {word} " for sign, word in SIGNS.items()}}  # noqa: RUF001
)
"""Variants of an apostrophe, and signs that are words."""

_QUOTED = re.compile(r"(?<!\w)'([^']*)'(?!\w)")

_HYPHEN = re.compile(r"(?<=\w)-|-(?!\.?[0-9])")


def spoken_forms(text: str, language: str = ENGLISH) -> list[list[str]]:
    """Return the ways to say each word or number of typed text."""
    plain = _QUOTED.sub(r" \1 ", compose_accents(text.lower()).translate(_PLAIN))
    return [_said(token, language) for token in _TOKEN.findall(_HYPHEN.sub(" ", plain))]


def first_wording(text: str) -> str:
    """Return the plainest way to say a typed text; empty if it has no word."""
    return " ".join(ways[0] for ways in spoken_forms(text))


def plain_form(text: str) -> str:
    """Return text in its first wording and without accents: forms of one text are the same."""
    return strip_accents(first_wording(text))


def _said(token: str, language: str) -> list[str]:
    try:
        return list(wordings(Fraction(token), language))
    except ValueError:  # no number, or too large to be said
        return [token]
