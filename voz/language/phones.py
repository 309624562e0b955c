"""Phones: the English ones and how far apart they are, and those of other languages; pure.

Those of other languages are named as in the International Phonetic Alphabet, and the network hears
them. pocketsphinx, whose acoustic model is English, gets the nearest English phones, which have
capitals, so both may stand in one line.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from voz.language.sentences.spelling import compose_accents

PHONE_NAMES = (
    "AA AE AH AO AW AY B CH D DH EH ER EY F G HH IH IY JH K L M N NG OW OY P R S SH T TH "
    "UH UW V W Y Z ZH"
)
"""Those of pocketsphinx's English acoustic model."""

PHONES = frozenset(PHONE_NAMES.split())

DISTANCES_FILE = Path(__file__).with_name("phone_distances.tsv")
"""The distances between English phones, as `tools/fit_confusion.py` measured them."""

NEAREST_ENGLISH_FILE = Path(__file__).with_name("nearest_english.tsv")
"""The nearest English phones of each phone that espeak-ng has in Spanish, French, Italian, German
and Portuguese."""

_NOT_A_PHONE = re.compile(r"\([a-z-]+\)|[ˈˌːʲʔ?\u0329\u032a-]")
"""Stress, length, signs of a syllable or of the teeth, and what language a foreign word is of."""

_TWICE = re.compile(r"(\w)\1")
"""A long phone of Italian."""


@dataclass(frozen=True)
class PhoneDistances:
    """The distances between phones in an acoustic model."""

    frames: Mapping[str, float]  # how many frames of 10 ms a phone lasts
    # What a frame of the first phone loses, in nats, if it is taken for the second.
    apart: Mapping[str, Mapping[str, float]]


@cache
def read_distances(path: Path = DISTANCES_FILE) -> PhoneDistances:
    """Read the table of phone distances that comes with voz."""
    lines = path.read_text(encoding="utf-8").splitlines()
    header, *rows = (line.split("\t") for line in lines if not line.startswith("#"))
    frames = {phone: float(length) for phone, length, *_ in rows}
    apart = {row[0]: dict(zip(header[2:], map(float, row[2:]), strict=True)) for row in rows}
    return PhoneDistances(frames, apart)


@cache
def nearest_english() -> Mapping[str, tuple[str, ...]]:
    """Read the nearest English phones of each phone."""
    lines = NEAREST_ENGLISH_FILE.read_text(encoding="utf-8").splitlines()
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
