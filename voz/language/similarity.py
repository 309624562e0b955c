"""Which commands sound alike to the acoustic model; pure.

The distance of two commands is the log-likelihood per frame that the recognizer would lose by
taking one for the other: each phone that is said is explained by the phones of the other command,
in order, and keeps its length. It is no plain edit distance: a hidden Markov model stretches a
phone over many frames at the cost of the mismatch alone, and cannot skip one in less than three.

Of very many sentences a sample is compared with its nearest neighbors: all pairs take quadratic
time.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import combinations, islice, product
from random import Random

from voz.language.phones import PhoneDistances, read_distances
from voz.language.sentences.command_set import Commands, Parse
from voz.language.sentences.expression import Value
from voz.language.sentences.neighbors import Neighbor, nearest
from voz.language.sentences.spelling import wordings

UNRELATED_LOSS = 7.5
"""Nats per frame, on average, of a phone explained by one with nothing in common."""

MIN_PHONE_FRAMES = 3
"""A phone's model has three states, and each takes a frame at least."""

LISTED_SIMILARITY = 0.65
"""Pairs from here on are in the table."""

MAX_COMPARED_VARIANTS = 8
"""Pronunciations of a command; a long sentence can have thousands."""


@dataclass(frozen=True)
class SimilarPair:
    """Two commands and how alike they sound."""

    first: str  # the command that stands first in the list
    second: str  # the other
    similarity: float  # 1 if they sound the same, near 0 if nothing in them does
    # The phones of each that the other does not share at its beginning or end.
    differ: tuple[str, str]


@dataclass(frozen=True)
class _Spoken:
    """One pronunciation of a command, with what its comparisons share."""

    phones: tuple[str, ...]
    frames: float
    cheapest: Mapping[str, float]  # what each phone loses at least if explained by this command


def find_similar(
    commands: Sequence[str],
    pronunciations: Mapping[str, Sequence[str]],
    at_least: float = LISTED_SIMILARITY,
    distances: PhoneDistances | None = None,
) -> list[SimilarPair]:
    """Find the pairs of normalized sentences that sound alike, the most similar first.

    The pronunciations are those of each of their words, such as "K OW L AH". The higher `at_least`,
    0 to 1, the faster. No distances are those of English phones.
    """
    distances = distances or read_distances()
    farthest = -math.log(at_least) * UNRELATED_LOSS if at_least > 0 else math.inf
    spoken = {command: _ways_to_say(command, pronunciations, distances) for command in commands}
    pairs = []
    for first, second in combinations(commands, 2):
        loss, said = _closest(spoken[first], spoken[second], distances, farthest)
        if loss <= farthest:
            alike = math.exp(-loss / UNRELATED_LOSS)
            pairs.append(SimilarPair(first, second, alike, _difference(*said)))
    return sorted(pairs, key=lambda pair: -pair.similarity)


def loss_between(one: Sequence[str], other: Sequence[str], distances: PhoneDistances) -> float:
    """Return the loss if phones are taken for others, nats; the mean of both directions."""
    frames = [sum(distances.frames[phone] for phone in phones) for phones in (one, other)]
    there, back = (_Spoken(tuple(p), f, {}) for p, f in zip((one, other), frames, strict=True))
    return (
        _loss(there, back, distances, math.inf) * frames[0]
        + _loss(back, there, distances, math.inf) * frames[1]
    ) / 2


def _ways_to_say(
    command: str, pronunciations: Mapping[str, Sequence[str]], distances: PhoneDistances
) -> list[_Spoken]:
    words = [pronunciations[word] for word in command.split()]
    ways = (" ".join(parts).split() for parts in islice(product(*words), MAX_COMPARED_VARIANTS))
    return [_spoken(tuple(phones), distances) for phones in ways]


def _spoken(phones: tuple[str, ...], distances: PhoneDistances) -> _Spoken:
    present = set(phones)
    cheapest = {
        phone: distances.frames[phone] * min(apart[other] for other in present)
        for phone, apart in distances.apart.items()
    }
    return _Spoken(phones, sum(distances.frames[phone] for phone in phones), cheapest)


def _closest(
    first: Sequence[_Spoken], second: Sequence[_Spoken], distances: PhoneDistances, farthest: float
) -> tuple[float, tuple[_Spoken, _Spoken]]:
    """Compare all pronunciations; a loss above `farthest` is not exact."""
    said = (first[0], second[0])
    least = math.inf
    for one, other in product(first, second):
        # Most pairs are far apart even without order and length, which is cheap to compute.
        if _at_least(one, other) > min(farthest, least):
            continue
        # One direction alone may lose twice as much as both on average.
        there = _loss(one, other, distances, 2 * farthest)
        back = _loss(other, one, distances, 2 * farthest - there)
        loss = (there + back) / 2
        if loss < least:
            least, said = loss, (one, other)
    return least, said


def _at_least(one: _Spoken, other: _Spoken) -> float:
    """Return a lower bound of the loss: each phone is explained by the other command's best."""
    there = sum(map(other.cheapest.__getitem__, one.phones)) / one.frames
    back = sum(map(one.cheapest.__getitem__, other.phones)) / other.frames
    return (there + back) / 2


def _loss(said: _Spoken, taken: _Spoken, distances: PhoneDistances, farthest: float) -> float:
    """Return what each frame of a command loses if it is taken for another one, nats.

    Dynamic programming: `losses[n]` is the least loss if n phones of `taken` explain what was said
    so far. A phone that was said is explained by the next phone of `taken` or its neighbors; a
    phone of `taken` that nobody said takes its least frames from its neighbors. Stops above
    `farthest`.
    """
    costs = [[distances.apart[phone][other] for other in taken.phones] for phone in said.phones]
    losses = [0.0]
    for each in costs[0]:
        losses.append(losses[-1] + MIN_PHONE_FRAMES * each)
    for phone, cost, following in zip(said.phones, costs, [*costs[1:], costs[-1]], strict=True):
        losses = _next_losses(losses, cost, following, distances.frames[phone])
        if min(losses) > farthest * said.frames:
            return math.inf
    return losses[-1] / said.frames


def _next_losses(
    losses: Sequence[float], cost: Sequence[float], following: Sequence[float], frames: float
) -> list[float]:
    """Advance by one phone; written for speed: it takes most of the time."""
    before = cost[0]
    least = losses[0] + frames * before
    reached = [least]
    for place, now in enumerate(cost):
        after = following[place]
        unsaid = least + MIN_PHONE_FRAMES * (now if now < after else after)
        as_next = losses[place] + frames * now
        ahead = cost[place + 1] if place + 1 < len(cost) else now
        beside = losses[place + 1] + frames * (now if now < ahead else ahead)
        least = min(unsaid, as_next, beside)
        reached.append(least)
    return reached


def _difference(one: _Spoken, other: _Spoken) -> tuple[str, str]:
    return differing_words(" ".join(one.phones), " ".join(other.phones))


GAP_COST = 22.0
"""Nats for each phone of a word that is too many or too few.

Its frames are explained by its neighbors, or three of theirs by it: about 4 nats each.
"""

MAX_PRONUNCIATIONS = 2
"""Of a word, that are compared."""


class WordDistances:
    """Costs by how words sound, in nats that the recognizer would lose; see `WordCosts`."""

    def __init__(
        self,
        spellings: Mapping[str, Sequence[Sequence[str]]],
        distances: PhoneDistances | None = None,
    ) -> None:
        """Take the phones of each word; without distances, those of English phones."""
        self._distances = distances or read_distances()
        self._spellings = {
            word: [tuple(way) for way in ways[:MAX_PRONUNCIATIONS]]
            for word, ways in spellings.items()
        }
        self._phones = {word: frozenset(ways[0]) for word, ways in self._spellings.items()}
        self.substitution_cost = lru_cache(maxsize=100_000)(self._instead)

    def _instead(self, word: str, other: str) -> float:
        ways, others = self._spellings[word], self._spellings[other]
        return min(loss_between(one, two, self._distances) for one in ways for two in others)

    def rough_cost(self, word: str, other: str) -> float:
        """Count the phones that only one of two words has."""
        return len(self._phones[word] ^ self._phones[other])

    def gap_cost(self, word: str) -> float:
        """Cost of leaving a word out, or inserting it."""
        return GAP_COST * len(self._spellings[word][0])

    def phones(self, words: str) -> str:
        """Return the phones of some words, as they are usually said."""
        return " ".join(phone for word in words.split() for phone in self._spellings[word][0])


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
    alike = math.exp(-near.cost / COMMAND_FRAMES / UNRELATED_LOSS)
    return SimilarPair(sentence, near.sentence, alike, (sound.phones(one), sound.phones(other)))


def differing_sets(pair: SimilarPair) -> frozenset[str]:
    """Return the words of each that the other does not share at its beginning or end."""
    return frozenset(differing_words(pair.first, pair.second))


def differing_words(first: str, second: str) -> tuple[str, str]:
    """Leave out the words (or phones) that both texts begin with, and those that both end with."""
    one, other = first.split(), second.split()
    while one and other and one[0] == other[0]:
        del one[0], other[0]
    while one and other and one[-1] == other[-1]:
        del one[-1], other[-1]
    return " ".join(one), " ".join(other)


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
        differs = _different_meanings(first, second) if first and second else frozenset()
        if differs and not any(known <= differs for known in kept):
            kept[differs] = pair
    return list(kept.values())


def _different_meanings(first: Parse, second: Parse) -> frozenset[object]:
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
