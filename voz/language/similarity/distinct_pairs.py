"""Selects the pairs that are reported: each confusion of meanings once; pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import lru_cache

from voz.language.sentences.command_set import Commands, Parse
from voz.language.sentences.expression import Value
from voz.language.sentences.number_words import wordings
from voz.language.similarity.confusion import SimilarPair

ANY_NUMBER = "{number}"
"""Stands for every spoken number, which nobody can reword."""


def distinct_pairs(pairs: Iterable[SimilarPair], commands: Commands) -> list[SimilarPair]:
    """Keep the most similar of the pairs that mix up the same meanings, most similar first.

    Two numbers in the same slot are no difference. A pair that differs in all that another pair
    differs in, and in more, is left out.
    """
    kept: dict[frozenset[object], SimilarPair] = {}
    parse = lru_cache(maxsize=None)(commands.parse)
    for pair in sorted(pairs, key=lambda pair: -pair.similarity):
        first, second = parse(pair.first), parse(pair.second)
        differs = _difference(first, second) if first and second else frozenset()
        if differs and not any(known <= differs for known in kept):
            kept[differs] = pair
    return list(kept.values())


def _difference(first: Parse, second: Parse) -> frozenset[object]:
    """Name two commands; within one command, each slot that differs with both values."""
    if first.command != second.command:
        return frozenset([frozenset([first.command, second.command])])
    one, other = _without_numbers(first), _without_numbers(second)
    return frozenset(
        (name, frozenset([one.get(name), other.get(name)]))
        for name in {*one, *other}
        if one.get(name) != other.get(name)
    )


def _without_numbers(parse: Parse) -> Mapping[str, Value]:
    return {
        name: ANY_NUMBER if _is_spoken_as_number(value, parse.text) else value
        for name, value in parse.slots.items()
    }


def _is_spoken_as_number(value: Value, sentence: str) -> bool:
    if isinstance(value, str):
        return False
    try:
        ways = wordings(Fraction(str(value)))
    except ValueError:  # nobody says it
        return False
    return any(f" {way} " in f" {sentence} " for way in ways)
