"""Which sentences of very many sound alike; pure.

Some are compared with those that are nearest to them in sound: to compare each with each other
takes a time that grows with their square.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import exp
from random import Random

from voz.language.acoustics.phone_distances import PhoneDistances
from voz.language.sentences.command_set import Commands
from voz.language.sentences.neighbors import Neighbor, nearest
from voz.language.similarity.confusion import UNRELATED_LOSS, SimilarPair
from voz.language.similarity.similarity_report import differing_sets, differing_words
from voz.language.similarity.word_distances import WordDistances

SAMPLED_SENTENCES = 60
"""Sentences of a long list that are compared with their neighbors; it takes a second or two."""

NEIGHBORS_PER_SENTENCE = 50
"""Of each: most of them may be the same sentence with another number in it."""

COMMAND_FRAMES = 85.0
"""Of a command, 10 ms each: those that come with voz have so many on average."""


def similar_pairs_by_sampling(
    commands: Commands,
    pronunciations: Mapping[str, Sequence[str]],
    distances: PhoneDistances | None = None,
) -> list[SimilarPair]:
    """Find pairs that sound alike among very many sentences.

    Args:
        commands: of a long list.
        pronunciations: of each of its words, such as "K OW L AH".
        distances: how far apart the phones are; None for those of English.

    Returns:
        The pairs; of those that differ in the same words the most alike. How alike they are
        depends on the words that differ, and not on the length of the rest.
    """
    spellings = {word: [way.split() for way in ways] for word, ways in pronunciations.items()}
    sound = WordDistances(spellings, distances)
    found: dict[frozenset[str], SimilarPair] = {}
    for sentence in _drawn(commands):
        for near in nearest(commands.automaton, sentence.split(), sound, NEIGHBORS_PER_SENTENCE):
            pair = _pair(sentence, near, sound)
            words = differing_sets(pair)
            if words not in found or pair.similarity > found[words].similarity:
                found[words] = pair
    return list(found.values())


def _drawn(commands: Commands) -> list[str]:
    """Draw sentences: of as many templates as possible one, then others."""
    every = range(len(commands.meanings))
    labels = sorted(Random(0).sample(every, min(SAMPLED_SENTENCES, len(every))))
    each = [text for label in labels for text in commands.automaton.sentences_with_label(label, 1)]
    return list(dict.fromkeys([*each, *commands.sample(SAMPLED_SENTENCES)]))[:SAMPLED_SENTENCES]


def _pair(sentence: str, near: Neighbor, sound: WordDistances) -> SimilarPair:
    one, other = differing_words(sentence, near.sentence)
    alike = exp(-near.cost / COMMAND_FRAMES / UNRELATED_LOSS)
    return SimilarPair(sentence, near.sentence, alike, (sound.phones(one), sound.phones(other)))
