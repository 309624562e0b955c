"""Pronunciations of speakers who are not American."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

Phones = tuple[str, ...]


def with_accents(dictionary: Mapping[str, Phones]) -> dict[str, Phones]:
    """Add to a dictionary the rounded vowel of `stop` and `rock`, which most accents have.

    More (`start` without r) makes commands alike. Variants are words, as `the(2)`.
    """
    known = {(_plain(word), phones) for word, phones in dictionary.items()}
    counts: dict[str, int] = {}
    for word in map(_plain, dictionary):
        counts[word] = counts.get(word, 0) + 1
    more = dict(dictionary)
    for name, phones in dictionary.items():
        word = _plain(name)
        rounded = _rounded(word, phones)
        if (word, rounded) not in known:
            known.add((word, rounded))
            counts[word] += 1
            more[f"{word}({counts[word]})"] = rounded
    return more


def spellings(dictionary: Mapping[str, Phones]) -> dict[str, list[Phones]]:
    """All pronunciations of each word of a dictionary."""
    found: dict[str, list[Phones]] = {}
    for name, phones in dictionary.items():
        found.setdefault(_plain(name), []).append(phones)
    return found


def added(before: Iterable[str], after: Mapping[str, Phones]) -> dict[str, Phones]:
    """The entries that a dictionary has more than before."""
    there = set(before)
    return {name: phones for name, phones in after.items() if name not in there}


def _rounded(word: str, phones: Phones) -> Phones:
    """Replace AA by AO where an o is written, but not before R (`sorry` keeps it)."""
    if "o" not in word:
        return phones
    pairs = zip(phones, (*phones[1:], ""), strict=True)
    return tuple("AO" if phone == "AA" and after != "R" else phone for phone, after in pairs)


def _plain(name: str) -> str:
    return name.partition("(")[0]
