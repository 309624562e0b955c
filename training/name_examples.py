"""What is heard where a name was said, and where speech comes nearest to one that nobody said."""

from __future__ import annotations

import random
from collections import defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from itertools import repeat
from pathlib import Path

import numpy as np
from mixing import at_level, augment
from speech import Clip, Pool, read

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import to_samples
from voz.cli.text_io import with_bar
from voz.recognition.name import NameEvidence, costs_around, find_evidence
from voz.recognition.network.ctc import Floats, Lattice, best_matches, lattice
from voz.recognition.network.score import PhonemeScorer
from voz.recognition.network.symbols import read_phone_symbols

Name = tuple[str, ...]
"""The phones of a name."""

LENGTHS = range(4, 12)
"""How many phones a name has."""

NEAREST = 40
"""So many stretches of others' speech for each name: those in which it fits best."""

PADDING_SAMPLES = SAMPLE_RATE // 2
"""Samples of silence around each word, and after each recording of others."""

PIECE = 20 * SAMPLE_RATE
"""Samples that are heard at once."""

MOST_TRIED = 100
"""So many halves are joined at most for each name."""

PARTS = 32
"""Tasks for several processes."""


def made_up(count: int, words: Sequence[Name]) -> list[Name]:
    """Names that nobody says: the first half of one word and the second half of another.

    Fewer than `count` if there are too few words.
    """
    rng = random.Random(1)
    known, names = {*words}, set[Name]()
    for _ in range(MOST_TRIED * count):
        one, other = rng.choice(words), rng.choice(words)
        name = one[: len(one) // 2] + other[len(other) // 2 :]
        if len(name) in LENGTHS and name not in known:
            names.add(name)
        if len(names) == count:
            break
    return sorted(names)


def of_words(clips: Sequence[Clip], pool: Pool) -> list[NameEvidence]:
    """What is heard where words are said, each clean and then in noise."""
    parts = [clips[part::PARTS] for part in range(PARTS)]
    with ProcessPoolExecutor() as processes:
        found = processes.map(_of_words, parts, range(PARTS), repeat(pool))
        return [one for part in with_bar(found, "Words", PARTS) for one in part]


def of_others(
    paths: Sequence[Path], names: Sequence[Name], pool: Pool | None = None
) -> list[NameEvidence]:
    """What is heard where names fit best in recordings in which nobody says them.

    Args:
        paths: the recordings.
        names: the names.
        pool: what is mixed into the recordings; None if they are heard as they are.
    """
    parts = [paths[part::PARTS] for part in range(PARTS)]
    with ProcessPoolExecutor() as processes:
        found = processes.map(partial(_scores, names=names), parts, range(PARTS), repeat(pool))
        scores = list(with_bar(found, "Others", PARTS))
        order = np.argsort(-np.concatenate(scores), axis=0)[:NEAREST]
        sought = defaultdict(list)
        for number, places in enumerate(order.T):
            for place in places.tolist():
                sought[place].append(names[number])
        firsts = np.cumsum([0, *map(len, scores)]).tolist()
        jobs = [
            {place - first: sought[place] for place in range(first, first + len(part))}
            for first, part in zip(firsts, scores, strict=False)
        ]
        evidence = processes.map(_of_others, parts, range(PARTS), repeat(pool), jobs)
        return [one for part in with_bar(evidence, "Nearest", PARTS) for one in part]


def seconds_of(paths: Sequence[Path]) -> float:
    """How long recordings last, with the pause after each, s."""
    return sum(len(piece) for piece in _pieces(paths, 0, None)) / SAMPLE_RATE


def _of_words(clips: Sequence[Clip], seed: int, pool: Pool) -> list[NameEvidence]:
    rng = np.random.default_rng(seed)
    found = []
    for clip in clips:
        phones = clip.phones or ()
        clean = np.pad(at_level(read(clip.path)), PADDING_SAMPLES)
        for sound in (clean, augment(clean, pool, rng)):
            found += _evidence(to_samples(sound, SAMPLE_RATE), [phones])
    return found


def _scores(paths: Sequence[Path], seed: int, pool: Pool | None, names: Sequence[Name]) -> Floats:
    """How well each name fits in each piece of some recordings, nats."""
    every = _lattice(*names)
    found = []
    for piece in _pieces(paths, seed, pool):
        sounds = _network().phone_likelihoods(piece)
        costs = costs_around(sounds, alone=True)
        found.append(best_matches(sounds.log_ratios, *costs, every).scores)
    return np.reshape(found, (-1, len(names)))


def _of_others(
    paths: Sequence[Path], seed: int, pool: Pool | None, sought: dict[int, list[Name]]
) -> list[NameEvidence]:
    """What is heard where the names that are sought in each piece fit best."""
    found = []
    for number, piece in enumerate(_pieces(paths, seed, pool)):
        if names := sought[number]:
            found += _evidence(piece, names)
    return found


def _evidence(sound: Samples, names: Sequence[Name]) -> list[NameEvidence]:
    sounds = _network().phone_likelihoods(sound)
    costs = costs_around(sounds, alone=True)
    return [find_evidence(sounds.log_ratios, *costs, _lattice(name)) for name in names]


@cache
def _network() -> PhonemeScorer:
    return PhonemeScorer({})


@cache
def _phone_numbers() -> dict[str, int]:
    return {phone: number for number, phone in enumerate(read_phone_symbols())}


def _lattice(*names: Name) -> Lattice:
    numbers = _phone_numbers()
    ways = ([numbers[phone] for phone in name] for name in names)
    return lattice([[[way]] for way in ways], len(numbers))


def _pieces(paths: Sequence[Path], seed: int, pool: Pool | None) -> Iterator[Samples]:
    """Recordings in pieces, with a pause after each."""
    rng = np.random.default_rng(seed)
    for path in paths:
        sound = np.pad(read(path), (PADDING_SAMPLES // 2, PADDING_SAMPLES))
        for at in range(0, len(sound), PIECE):
            piece = sound[at : at + PIECE]
            mixed = piece if pool is None else augment(at_level(piece), pool, rng)
            yield to_samples(mixed, SAMPLE_RATE)
