"""Converts typed text to spoken words; pure."""

from __future__ import annotations

import re
from fractions import Fraction

from voz.language.sentences.number_words import wordings
from voz.language.sentences.spelling import COMBINING_SIGN, compose_accents

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


def _said(token: str) -> list[str]:
    try:
        return list(wordings(Fraction(token)))
    except ValueError:  # no number, or too large to be said
        return [token]
