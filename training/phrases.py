"""Phrases of common words, half of them in pairs one phone apart, as "fold arm" and "cold arm"."""

from __future__ import annotations

import random
from collections import defaultdict
from collections.abc import Mapping, Sequence

LENGTHS = (1, 1, 1, 2, 2, 3, 4)
"""Words in a phrase."""

PAIRS = 0.5
"""How many of the phrases are read a second time with a neighbor in the place of a word."""


def one_phone_apart(phones: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Find the neighbors of each word: one phone is another, or one of the two has one more."""
    words, alike = defaultdict(list), defaultdict(set)
    for word, said in phones.items():
        words[tuple(said)].append(word)
    near: dict[tuple[str, ...], set[tuple[str, ...]]] = {said: set() for said in words}
    for said in words:
        for place in range(len(said)):
            before, behind = said[:place], said[place + 1 :]
            alike[before, behind].add(said)
            if before + behind in words:
                near[said].add(before + behind)
                near[before + behind].add(said)
    for group in alike.values():
        for said in group:
            near[said] |= group - {said}
    return {
        word: sorted(other for way in near[tuple(said)] for other in words[way])
        for word, said in phones.items()
    }


def choose_phrases(
    near: Mapping[str, Sequence[str]], clips: int, rng: random.Random
) -> list[tuple[Sequence[str], ...]]:
    """Choose phrases, so many in all; each alone, or with one that sounds nearly the same.

    Args:
        near: for each word what `one_phone_apart` returns.
        clips: how many.
        rng: of the choice.
    """
    words = [*near]
    paired = [word for word in words if near[word]]
    found: list[tuple[Sequence[str], ...]] = []
    count = 0
    while count < clips:
        phrase = rng.choices(words, k=rng.choice(LENGTHS))
        if rng.random() >= PAIRS:
            found.append((phrase,))
            count += 1
            continue
        place = rng.randrange(len(phrase))
        phrase[place] = rng.choice(paired)
        found.append((phrase, with_word(phrase, place, rng.choice(near[phrase[place]]))))
        count += 2
    return found


def with_word(phrase: Sequence[str], place: int, word: str) -> Sequence[str]:
    """A phrase with another word at a place."""
    return [*phrase[:place], word, *phrase[place + 1 :]]
