"""Which symbols of the network stand for each phone of a dictionary."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from voz.language.phones import in_english
from voz.recognition.network.ctc import Floats
from voz.recognition.network.phoneme_network import BLANK_SYMBOLS, BLANKS

PHONE_SYMBOLS_FILE = Path(__file__).with_name("ipa.tsv")
"""The symbols of the network for each phone of the dictionary."""

OTHER_PHONE_SYMBOLS_FILE = Path(__file__).with_name("ipa_phones.tsv")
"""The same for the phones of other languages."""

LAX_SHARE = 0.2
"""Share of a symbol that quick or relaxed speech has in place of a phone, or of the blank where it
leaves the phone out, as in Spanish `apaga` (`benchmarks/language.py`)."""

LEFT_OUT_SHARE = 0.05
"""The same of the blank for the only phone of a word, as French `à`: less than what a phone earns,
so that a sentence gains nothing by words that were not said."""

UNSTRESSED = "*"
"""Sign of the phone of such a word."""

LETTER = re.compile(r".[\u0300-\u036f]*")
"""Of a phone, with the signs put to it."""


def with_symbols(phones: Sequence[str]) -> tuple[str, ...]:
    """Replace the phones that have no symbols: by their letters, as `ts`, or nearest English ones.

    English phones of other languages' words stand for themselves.
    """
    known = {*read_phone_symbols(), *read_phone_symbols(OTHER_PHONE_SYMBOLS_FILE)}
    split: list[str] = []
    for phone in phones:
        letters = LETTER.findall(phone)
        split += letters if phone not in known and known.issuperset(letters) else [phone]
    return in_english(split, known)


def unstressed(phones: Sequence[str]) -> tuple[str, ...]:
    """The phones of a word that quick speech leaves out; English ones stay."""
    others = read_phone_symbols(OTHER_PHONE_SYMBOLS_FILE)
    return tuple(phone + UNSTRESSED if phone in others else phone for phone in phones)


@cache
def read_phone_symbols(file: Path = PHONE_SYMBOLS_FILE, column: int = 1) -> Mapping[str, list[str]]:
    """Read the symbols of the network for each phone of the dictionary.

    The next column of a table has those of quick or relaxed speech.
    """
    rows = [line.split("\t") for line in file.read_text(encoding="utf-8").splitlines()]
    return {row[0]: row[column].split() if column < len(row) else [] for row in rows}


def symbols_of_other_languages() -> dict[str, dict[str, float]]:
    """The symbols of each phone of other languages, and of each unstressed one, with their shares.

    The share of a symbol is how much of its probability counts for the phone.
    """
    said = read_phone_symbols(OTHER_PHONE_SYMBOLS_FILE)
    lax = read_phone_symbols(OTHER_PHONE_SYMBOLS_FILE, column=2)
    shares = {
        phone: dict.fromkeys(lax[phone], LAX_SHARE) | dict.fromkeys(alike, 1.0)
        for phone, alike in said.items()
    }
    left_out = dict.fromkeys(BLANK_SYMBOLS, LEFT_OUT_SHARE)
    return shares | {f"{phone}{UNSTRESSED}": left_out | own for phone, own in shares.items()}


def symbols_of_phones(symbols: Sequence[str], phones: Collection[Mapping[str, float]]) -> Floats:
    """A matrix that adds up the symbols of each phone, and in its last column the blanks."""
    matrix = np.zeros((len(symbols), len(phones) + 1))
    for number, shares in enumerate(phones):
        matrix[[symbols.index(symbol) for symbol in shares], number] = [*shares.values()]
    matrix[-BLANKS:, -1] = 1
    return matrix
