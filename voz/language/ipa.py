"""Phones of other languages by their names in the International Phonetic Alphabet; pure.

The network hears them. pocketsphinx, whose acoustic model is English, gets the nearest English
phones, which have capitals, so both may stand in one line.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from functools import cache
from pathlib import Path

from voz.language.pronunciation import PHONES
from voz.language.sentences.spelling import compose_accents

PHONES_FILE = Path(__file__).with_name("nearest_english.tsv")
"""The nearest English phones of each phone that espeak-ng has in Spanish, French, Italian, German
and Portuguese."""

_NOT_A_PHONE = re.compile(r"\([a-z-]+\)|[ˈˌːʲʔ?\u0329\u032a-]")
"""Stress, length, signs of a syllable or of the teeth, and what language a foreign word is of."""

_TWICE = re.compile(r"(\w)\1")
"""A long phone of Italian."""


@cache
def nearest_english() -> Mapping[str, tuple[str, ...]]:
    """Read the nearest English phones of each phone."""
    lines = PHONES_FILE.read_text(encoding="utf-8").splitlines()
    return {
        phone: tuple(near.split()) for phone, _, near in (line.partition("\t") for line in lines)
    }


@cache
def known_phones() -> frozenset[str]:
    """The phones that a pronunciation may have: those of the table, and the English ones."""
    return PHONES | nearest_english().keys()


def parse_phones(written: str) -> tuple[str, ...]:
    """The phones that espeak-ng writes for a word, such as `k_w_ˈa_t_ɾ_o`."""  # noqa: RUF002
    plain = _TWICE.sub(r"\1", _NOT_A_PHONE.sub("", compose_accents(written)))
    return tuple(phone for phone in re.split("[_ ]+", plain) if phone)


def in_english(phones: Iterable[str], kept: Collection[str] = PHONES) -> tuple[str, ...]:
    """Replace phones by the nearest English ones, but those that are to be kept."""
    near = nearest_english()
    return tuple(new for phone in phones for new in ((phone,) if phone in kept else near[phone]))
