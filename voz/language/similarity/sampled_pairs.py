"""Which of very many sentences sound alike; pure.

A sample is compared with its nearest neighbors: to compare all pairs takes quadratic time.
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
"""They take a second or two."""

NEIGHBORS_PER_SENTENCE = 50
"""Most may be the same sentence with another number."""

COMMAND_FRAMES = 85.0
"""Average length of a packaged command, frames of 10 ms."""


def similar_pairs_by_sampling(
    commands: Commands,
    pronunciations: Mapping[str, Sequence[str]],
    distances: PhoneDistances | None = None,
) -> list[SimilarPair]:
    """Find pairs that sound alike; of those that differ in the same words the most similar.

    The similarity depends on the words that differ, not on the length of the rest.
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
    """Draw sentences: one of each of as many templates as possible, then others."""
    every = range(len(commands.meanings))
    labels = sorted(Random(0).sample(every, min(SAMPLED_SENTENCES, len(every))))
    each = [text for label in labels for text in commands.automaton.sentences_with_label(label, 1)]
    return list(dict.fromkeys([*each, *commands.sample(SAMPLED_SENTENCES)]))[:SAMPLED_SENTENCES]


def _pair(sentence: str, near: Neighbor, sound: WordDistances) -> SimilarPair:
    one, other = differing_words(sentence, near.sentence)
    alike = exp(-near.cost / COMMAND_FRAMES / UNRELATED_LOSS)
    return SimilarPair(sentence, near.sentence, alike, (sound.phones(one), sound.phones(other)))
