"""Measure `voz/recognition/name_allowances.tsv` anew: how near talk comes to each phone.

Run `python tools/fit_name_allowances.py MANIFEST...` with hours of talk. Words that nobody says in
it are looked for as a robot's name is. How well a word fits in the talk .1 times an hour follows
from the times when it fits best. It falls with each phone, more so with one that is rare and sounds
like no other: the sum of that over the phones of a name, less a constant, is by how much the name
may fit worse than the likeliest phones.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import numpy.typing as npt
import typer

from voz.apps.recordings.manifest import Clip, read_manifest
from voz.audio import SAMPLE_RATE
from voz.audio.capture.sound_files import read_blocks
from voz.cli.text_io import with_bar
from voz.errors import VozError
from voz.language.pronunciation.lexicon import PHONE_NAMES, read_cmudict
from voz.recognition.phoneme_scorer import PhonemeScorer
from voz.recognition.robot_name import ALLOWANCES_FILE, match_names

Floats = npt.NDArray[np.float64]

PHONES = PHONE_NAMES.split()
LENGTHS = range(4, 11)
"""Phones of a word."""

OFTEN = 0.1
"""False alarms in an hour."""

FIRST, LAST = 3, 30
"""Ranks of the scores from which the rarer ones follow; the first two may be the word itself."""

SHRINKAGE = 10.0
"""So many words' worth of evidence that all phones count alike."""

PARTS = 16
PIECE = 20 * SAMPLE_RATE
"""Samples that are heard at once."""

PAUSE = np.zeros(SAMPLE_RATE // 2, np.int16)


class Scores(NamedTuple):
    """Samples of talk, and how well each word fits in each piece of it, nats."""

    samples: int
    best: Floats


def choose_words(said: set[str], coverage: int) -> dict[str, list[str]]:
    """Words that nobody says, with their phones: each phone at least so often, if words have it."""
    known = {}
    for line in read_cmudict().decode().splitlines():
        word, *phones = line.split()
        if word.isalpha() and len(phones) in LENGTHS and word not in said:
            known[word] = phones
    order = sorted(known)
    random.Random(1).shuffle(order)
    covered = Counter(dict.fromkeys(PHONES, 0))
    chosen = {}
    for word in order:
        if min(covered[phone] for phone in known[word]) < coverage:
            chosen[word] = known[word]
            covered.update(known[word])
    return chosen


def hear(clips: Sequence[Clip], words: dict[str, list[str]]) -> Scores:
    """Look for words in talk."""
    network = PhonemeScorer({word: [phones] for word, phones in words.items()})
    lattice = network.lattice_of(*words)
    samples, found = 0, []
    for clip in clips:
        sound = np.concatenate([*read_blocks(clip.path), PAUSE])
        samples += len(sound)
        for at in range(0, len(sound), PIECE):
            sounds = network.phone_likelihoods(sound[at : at + PIECE])
            found.append(match_names(sounds, lattice, alone=True).scores)
    return Scores(samples, np.array(found).reshape(-1, len(words)))


def in_parts(clips: Sequence[Clip]) -> Iterator[Sequence[Clip]]:
    """Split talk for several processes."""
    yield from (clips[part::PARTS] for part in range(min(PARTS, len(clips))))


def reached(best: Floats, hours: float) -> Floats:
    """The score that each word reaches `OFTEN` times an hour: rarer ones fall exponentially."""
    ranks = np.arange(FIRST, min(LAST, len(best)) + 1)
    rarer = np.log((ranks - 0.5) / (OFTEN * hours))
    highest = -np.sort(-best, axis=0)[ranks - 1]
    lines = np.linalg.lstsq(np.stack([np.ones(len(ranks)), rarer], axis=1), highest)[0]
    return np.asarray(lines[0])


def fit(counts: Floats, scores: Floats) -> tuple[float, Floats]:
    """By how much scores fall with each phone, nats, and the score without any.

    Args:
        counts: of each phone, words x phones.
        scores: of the words, nats.
    """
    slope, start = np.polyfit(counts.sum(axis=1), scores, 1)
    design = np.column_stack([np.ones(len(scores)), counts])
    prior = SHRINKAGE * np.eye(design.shape[1])
    prior[0, 0] = 0
    rest = scores - design @ np.array([start, *[slope] * len(PHONES)])
    more = np.linalg.solve(design.T @ design + prior, design.T @ rest)
    return float(start + more[0]), -(slope + more[1:])


def main(
    manifests: Annotated[list[Path], typer.Argument(help="List talk.")],
    coverage: Annotated[int, typer.Option(min=1, help="Words with each phone, at least.")] = 70,
    out: Annotated[Path, typer.Option(help="The table.")] = ALLOWANCES_FILE,
) -> None:
    """Write the table, and print how well it predicts what talk comes near to.

    Example: python tools/fit_name_allowances.py people/manifest.tsv
    """
    try:
        talk = [clip for path in manifests for clip in read_manifest(path) if clip.kind == "talk"]
    except VozError as error:
        raise typer.BadParameter(str(error)) from None
    if not talk:
        raise typer.BadParameter("no recording is of the kind talk; give a manifest of talk")
    words = choose_words({word for clip in talk for word in clip.text.split()}, coverage)
    parts = list(in_parts(talk))
    with ProcessPoolExecutor() as pool:
        heard = list(with_bar(pool.map(partial(hear, words=words), parts), "Hearing", len(parts)))
    hours = sum(part.samples for part in heard) / SAMPLE_RATE / 3600
    scores = reached(np.concatenate([part.best for part in heard]), hours)
    counts = np.array([[phones.count(p) for p in PHONES] for phones in words.values()], float)
    start, allowances = fit(counts, scores)
    lines = [f"{phone}\t{nats:.2f}\n" for phone, nats in zip(PHONES, allowances, strict=True)]
    out.write_text("".join(lines), encoding="utf-8")
    missed = np.std(scores - start + counts @ allowances)
    print(f"{len(words)} words in {hours:.2f} h; they differ from the table by {missed:.1f} nats")
    print(f"the average name reaches its sum less {start:.1f} nats {OFTEN} times an hour")


if __name__ == "__main__":
    typer.run(main)
