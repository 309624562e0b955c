"""Fit by which sounds the robot's name is known: `voz/recognition/name_weights.npz`.

    python training/name_weights.py --speech FOLDER MANIFEST...

FOLDER has words whose phones are known, as `synthesize.py` makes them, and MANIFEST lists hours of
talk. Where a word fits best in its own recording, clean or in noise, it was said. Where a made-up
name fits best in talk, clean or in noise, or in another word in noise, it was not. A logistic
regression over what is heard there tells the two apart. One half of the speakers of talk, by a
checksum of their names, is left to who measures.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple
from zlib import crc32

import numpy as np
import torch
import typer
from name_examples import LENGTHS, made_up, of_others, of_words, seconds_of
from speech import Clip, Pool, load_pools
from torch.nn import functional

from voz.apps.recordings.manifest import read_manifests
from voz.errors import VozError
from voz.recognition.name import (
    CONTEXT_WEIGHT,
    LENGTH_LIMITS,
    WEIGHTS_FILE,
    NameEvidence,
    NameWeights,
    write_weights,
)
from voz.recognition.network.ctc import Floats, Places
from voz.recognition.network.symbols import read_phone_symbols

PHONES = len(read_phone_symbols())

CHECKED = 4
"""One of so many speakers tells how often talk is taken for a name; by the others it is fitted."""

PER_PHONE = 0.35
"""Log-odds more for each phone of a name. What comes nearest in talk has .6 to .9 less for each;
with the whole of that, names of few phones miss more than the others win.
"""

OTHER_WORDS = 5
"""One of so many words is heard as what is no name: alone, and in noise."""

OFTEN = 0.1
"""False alarms of each name in an hour."""

STEPS, BATCH, RATE = 700, 512, 5e-3
"""Steps of the regression, examples of each kind in one, and the first rate of learning, which
falls to nothing."""

SHRINKAGE = 3e-4
"""What the sum of the squares of the weights costs, nats."""


class Examples(NamedTuple):
    """Evidence of names, padded with zeros to the same number of phones.

    Attributes:
        fits: of each example, nats.
        others: log-odds of each example for what no weight is fitted for.
        phones: examples x phones.
        told: examples x phones x what is heard of each and how long it is.
    """

    fits: Floats
    others: Floats
    phones: Places
    told: Floats

    def some(self, rng: np.random.Generator) -> Examples:
        """A batch of them."""
        chosen = rng.integers(len(self.fits), size=BATCH)
        return Examples(*(array[chosen] for array in self))


def examples(evidence: Sequence[NameEvidence]) -> Examples:
    """Put evidence side by side."""
    shape = len(evidence), max(LENGTHS)
    kinds = np.eye(len(LENGTH_LIMITS) + 1, dtype=np.float32)
    phones = np.zeros(shape, np.intp)
    told = np.zeros((*shape, PHONES + 1 + len(kinds)), np.float32)
    for number, one in enumerate(evidence):
        phones[number, : len(one.phones)] = one.phones
        told[number, : len(one.phones)] = np.hstack([one.heard, kinds[one.lengths]])
    fits = np.array([one.fit for one in evidence], np.float32)
    others = np.array([-CONTEXT_WEIGHT * one.around for one in evidence], np.float32)
    return Examples(fits, others, phones, told)


def fit(said: Examples, not_said: Examples) -> NameWeights:
    """Fit the regression to examples of both kinds, each of which counts for a half."""
    torch.set_num_threads(1)  # batches are small: two threads take twice as long
    rng = np.random.default_rng(1)
    line = torch.zeros(2, requires_grad=True)
    table = torch.zeros(PHONES, said.told.shape[-1], requires_grad=True)
    optimizer = torch.optim.Adam([line, table], lr=RATE)
    rate = torch.optim.lr_scheduler.LambdaLR(optimizer, lambda step: 1 - (step + 1) / STEPS)
    was_said = torch.tensor([1.0, 0.0]).repeat_interleave(BATCH)
    for _ in range(STEPS):
        kinds = zip(said.some(rng), not_said.some(rng), strict=True)
        fits, others, phones, told = (torch.from_numpy(np.concatenate(both)) for both in kinds)
        log_odds = line[0] + line[1] * fits + others
        log_odds = log_odds + (functional.embedding(phones, table) * told).sum((1, 2))
        missed = functional.binary_cross_entropy_with_logits(log_odds, was_said, reduction="sum")
        optimizer.zero_grad()
        (missed / BATCH + SHRINKAGE * table.square().sum()).backward()
        optimizer.step()
        rate.step()
    heard, lengths = np.split(table.detach().numpy(), [PHONES + 1], axis=1)
    return NameWeights(*line.tolist(), heard, lengths, np.zeros(PHONES))


def with_threshold(
    weights: NameWeights, rooms: Iterable[Sequence[NameEvidence]], alarms: float
) -> NameWeights:
    """Move the log-odds so that at most so many of what is nearest in any room are above zero."""
    limits = [
        sorted((one.log_odds(weights) for one in room), reverse=True)[round(alarms)]
        for room in rooms
    ]
    return weights._replace(constant=weights.constant - max(limits))


def with_typical(weights: NameWeights, said: Sequence[NameEvidence]) -> NameWeights:
    """Add what each phone of a name that is said counts for, by least squares."""
    counts = [np.bincount(one.phones, minlength=PHONES) for one in said]
    more = np.array([one.log_odds(weights) for one in said]) - weights.constant
    return weights._replace(typical=np.linalg.lstsq(np.array(counts, float), more)[0])


def words_in(folders: Sequence[Path]) -> tuple[list[Clip], Pool]:
    """The recordings of words as long as a name, and what is mixed into them."""
    pool, held_back = load_pools(folders)
    every = [clip for group in (*pool.groups, held_back) for clip in group]
    return [clip for clip in every if len(clip.phones or ()) in LENGTHS], pool


def talk_in(manifests: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """The talk by which the weights are fitted, and that by which their threshold is chosen."""
    learned, checked = [], []
    for recording in read_manifests(manifests):
        checksum = crc32(recording.speaker.encode())
        if recording.kind == "talk" and checksum % 2:
            (learned if checksum // 2 % CHECKED else checked).append(recording.path)
    return learned, checked


def main(
    talk: Annotated[list[Path], typer.Argument(help="List talk.")],
    speech: Annotated[
        list[Path], typer.Option(help="A folder of words, with a manifest.tsv; may be repeated.")
    ],
    names: Annotated[int, typer.Option(min=1, help="Names that are made up.")] = 600,
    out: Annotated[Path, typer.Option(help="The weights.")] = WEIGHTS_FILE,
) -> None:
    """Write the weights, and print how well they tell names from talk.

    Example: python training/name_weights.py --speech words people/manifest.tsv
    """
    try:
        words, pool = words_in(speech)
        learned, checked = talk_in(talk)
    except VozError as error:
        raise typer.BadParameter(str(error)) from None
    except (OSError, KeyError) as error:
        raise typer.BadParameter(f"{error}; give folders with a manifest.tsv") from None
    made = made_up(names, [clip.phones or () for clip in words]) if words else []
    if not learned or not checked or not made:
        raise typer.BadParameter("too few speakers of talk, or too few words of 4 to 11 phones")
    said = of_words(words, pool)
    others = of_others(learned, made)
    others += of_others(learned, made, pool)
    others += of_others([clip.path for clip in words[::OTHER_WORDS]], made, pool)
    weights = fit(examples(said), examples(others))
    weights = weights._replace(lengths=weights.lengths + PER_PHONE)
    nearest = [of_others(checked, made, mixed) for mixed in (None, pool)]
    weights = with_threshold(weights, nearest, OFTEN * len(made) * seconds_of(checked) / 3600)
    write_weights(with_typical(weights, said[1::2]), out)
    for title, some in (("clean", said[::2]), ("in noise", said[1::2])):
        missed = np.mean([one.log_odds(weights) < 0 for one in some])
        print(f"{missed:.3f} of {len(some)} words {title} are missed")
    print(f"at {OFTEN} false alarms of each name in an hour, by other speakers")


if __name__ == "__main__":
    typer.run(main)
