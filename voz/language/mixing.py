"""Which sentences of very many sound alike; pure.

Some are compared with those that are nearest to them in sound: to compare each with each other
takes a time that grows with their square.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import exp

from voz.language.alike import differing, words_that_differ
from voz.language.confusion import UNLIKE, AlikePair
from voz.language.phone_distances import Distances
from voz.language.templates.commands import Commands
from voz.language.templates.distances import WordDistances
from voz.language.templates.neighbours import Near, nearest

LOOKED_AT = 60
"""Sentences of a long list that are compared with their neighbours; it takes a second or two."""

NEIGHBOURS = 4
"""Of each."""

USUAL_FRAMES = 85.0
"""Of a command, 10 ms each: those that come with voz have so many on average."""


def pairs_of_many(
    commands: Commands,
    pronunciations: Mapping[str, Sequence[str]],
    distances: Distances | None = None,
) -> list[AlikePair]:
    """Find pairs that sound alike among very many sentences.

    Args:
        commands: of a long list.
        pronunciations: of each of its words, such as "K OW L AH".
        distances: how far apart the phones are; None for those of English.

    Returns:
        The pairs, the most alike first; of those that differ in the same words the most alike.
        How alike they are hangs on the words that differ, and not on the length of the rest.
    """
    spellings = {word: [way.split() for way in ways] for word, ways in pronunciations.items()}
    sound = WordDistances(spellings, distances)
    found: dict[frozenset[str], AlikePair] = {}
    for sentence in commands.sample(LOOKED_AT):
        for near in nearest(commands.network, sentence.split(), sound, NEIGHBOURS):
            if not mean_the_same(commands, sentence, near.sentence):
                alike = exp(-near.cost / USUAL_FRAMES / UNLIKE)
                pair = AlikePair(sentence, near.sentence, alike, _phones(sentence, near, sound))
                words = words_that_differ(pair)
                if words not in found or alike > found[words].alike:
                    found[words] = pair
    return sorted(found.values(), key=lambda pair: -pair.alike)


def _phones(sentence: str, near: Near, sound: WordDistances) -> tuple[str, str]:
    """The phones of the words that differ."""
    one, other = differing(sentence, near.sentence)
    return sound.phones(one), sound.phones(other)


def mean_the_same(commands: Commands, one: str, other: str) -> bool:
    """Whether it does not matter which of two sentences was said."""
    first, second = commands.parse(one), commands.parse(other)
    return bool(first and second and first[1:] == second[1:])
