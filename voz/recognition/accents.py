"""Pronunciations of speakers who are not American."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path

Phones = tuple[str, ...]

BRITISH_FILE = Path(__file__).with_name("british.tsv")
"""Words that are said otherwise outside America, with their phones there."""


def with_british(dictionary: Mapping[str, Phones]) -> dict[str, Phones]:
    """Add the pronunciations of `BRITISH_FILE` to a dictionary; variants are words, as `the(2)`.

    More (`start` without r) makes commands alike.
    """
    return _with_variants(dictionary, lambda word, _: _british().get(word, ()))


def with_rounded(dictionary: Mapping[str, Phones]) -> dict[str, Phones]:
    """Add the rounded vowel of `stop` and `rock`, which most accents have, for pocketsphinx.

    The network hears that vowel as a symbol of the American one.
    """
    return _with_variants(dictionary, lambda word, known: [_rounded(word, way) for way in known])


def _with_variants(
    dictionary: Mapping[str, Phones], variants: Callable[[str, list[Phones]], Iterable[Phones]]
) -> dict[str, Phones]:
    more = dict(dictionary)
    for word, known in spellings(dictionary).items():
        new = [way for way in dict.fromkeys(variants(word, known)) if way not in known]
        for number, way in enumerate(new, start=len(known) + 1):
            more[f"{word}({number})"] = way
    return more


def spellings(dictionary: Mapping[str, Phones]) -> dict[str, list[Phones]]:
    """All pronunciations of each word of a dictionary."""
    found: dict[str, list[Phones]] = {}
    for name, phones in dictionary.items():
        found.setdefault(plain_word(name), []).append(phones)
    return found


def added(before: Iterable[str], after: Mapping[str, Phones]) -> dict[str, Phones]:
    """The entries that a dictionary has more than before."""
    there = set(before)
    return {name: phones for name, phones in after.items() if name not in there}


@cache
def _british() -> dict[str, list[Phones]]:
    found: dict[str, list[Phones]] = {}
    for line in BRITISH_FILE.read_text(encoding="utf-8").splitlines():
        word, _, phones = line.partition("\t")
        found.setdefault(word, []).append(tuple(phones.split()))
    return found


def _rounded(word: str, phones: Phones) -> Phones:
    """Replace AA by AO where an o is written, but not before R (`sorry` keeps it)."""
    if "o" not in word:
        return phones
    pairs = zip(phones, (*phones[1:], ""), strict=True)
    return tuple("AO" if phone == "AA" and after != "R" else phone for phone, after in pairs)


def plain_word(name: str) -> str:
    """The word of an entry of a dictionary, which may be a variant, as `the(2)`."""
    return name.partition("(")[0]
