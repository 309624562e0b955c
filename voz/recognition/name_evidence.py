"""How surely the robot's name was said where it fits best in a sound.

A logistic regression over what the network hears while each phone of the name is said, and over how
long that lasts. A phone that is often taken for another, as TH for F, counts little against a name
if it is; one for which talk is seldom taken counts much for it. `training/name_weights.py` fits the
weights, by words that voices say, and by what comes nearest to other words in talk.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from voz.recognition.ctc import NOWHERE, Floats, Lattice, Places, best_path

WEIGHTS_FILE = Path(__file__).with_name("name_weights.npz")

LEAST_LIKELY = -9.2
"""Relative log-likelihood of a phone at least, nats: what is lower tells no more. Half of it is the
zero of `heard`."""

LENGTH_LIMITS = np.array([2, 3, 4, 5, 7, 9, 12, 16, 25])
"""Moments that separate the classes of how long it takes until the next phone."""

MOST_BEFORE, MOST_AFTER = 1, 2
"""Moments around a phone in which the network may hear another in its place."""

AROUND = 0.8
"""Log-odds against a name for each nat that is against what is said around it. Fitted like the
others it is 0.5, but then a name that is said clearly in talk that goes on wakes the robot.
"""


class NameWeights(NamedTuple):
    """The weights of the regression.

    Attributes:
        constant: log-odds of a name without phones.
        fit: log-odds for each nat of `fit` in the evidence.
        heard: log-odds for each nat of `heard` in the evidence, phones of the name x what is
            heard: each phone, and last a blank.
        lengths: log-odds for each class of length, phones of the name x classes.
        typical: log-odds for each phone of a name that is said in noise, in the mean.
    """

    constant: float
    fit: float
    heard: Floats
    lengths: Floats
    typical: Floats


class NameEvidence(NamedTuple):
    """Where a name fits best, and what is heard there.

    Attributes:
        fit: relative log-likelihood of the name, nats; infinitely low if it fits nowhere.
        around: what is said around it costs, nats.
        begin: its first moment.
        end: the moment after its last.
        phones: the number of each of its phones.
        heard: relative log-likelihood of each phone, and of a blank, while each phone is said,
            nats; phones of the name x (phones of the dictionary + 1).
        lengths: the class of length of each of its phones.
    """

    fit: float
    around: float
    begin: int
    end: int
    phones: Places
    heard: Floats
    lengths: Places

    def log_odds(self, weights: NameWeights) -> float:
        """The log-odds that the name was said."""
        heard = float((weights.heard[self.phones] * self.heard).sum())
        lengths = float(weights.lengths[self.phones, self.lengths].sum())
        whole = weights.constant + weights.fit * self.fit - AROUND * self.around
        return whole + heard + lengths


@cache
def read_weights(file: Path = WEIGHTS_FILE) -> NameWeights:
    """Read the weights."""
    with np.load(file) as arrays:
        constant, fit = arrays["constant"].item(), arrays["fit"].item()
        return NameWeights(constant, fit, arrays["heard"], arrays["lengths"], arrays["typical"])


def write_weights(weights: NameWeights, file: Path) -> None:
    """Write the weights."""
    arrays: dict[str, Any] = {name: np.float32(v) for name, v in weights._asdict().items()}
    np.savez(file, **arrays)


def find_evidence(relative: Floats, before: Floats, behind: Floats, name: Lattice) -> NameEvidence:
    """Find where a name fits best, and what is heard there.

    Args:
        relative: log-probabilities less that of the likeliest symbol, nats, moments x (phones of
            the dictionary and a blank).
        before: cost of beginning at each moment, nats.
        behind: cost of ending at each moment, nats.
        name: its lattice.
    """
    path = best_path(relative, before, behind, name)
    nodes = np.array(path.nodes, np.intp)
    symbols = name.symbols[nodes]
    is_phone = symbols != relative.shape[1] - 1
    begins = np.flatnonzero(is_phone & (np.diff(nodes, prepend=NOWHERE) != 0))
    ends = np.flatnonzero(is_phone & (np.diff(nodes, append=NOWHERE) != 0))
    firsts, lasts = path.begin + begins, path.begin + ends
    nexts = np.append(firsts[1:], lasts[-1:] + MOST_AFTER + 1)
    end = path.begin + len(nodes)
    around = float(before[path.begin] + behind[end - 1]) if path.nodes else 0.0
    return NameEvidence(
        path.score + around,
        around,
        path.begin,
        end,
        symbols[begins],
        _heard(relative, firsts - MOST_BEFORE, np.minimum(nexts, lasts + 1 + MOST_AFTER)),
        np.searchsorted(LENGTH_LIMITS, nexts - firsts),
    )


def _heard(relative: Floats, begins: Places, ends: Places) -> Floats:
    """How likely each phone is at most in each of some stretches, and a blank at least."""
    heard = np.empty((len(begins), relative.shape[1]))
    for number, (begin, end) in enumerate(zip(begins, ends, strict=True)):
        stretch = relative[max(0, begin) : end]
        heard[number, :-1] = stretch[:, :-1].max(axis=0)
        heard[number, -1] = stretch[:, -1].min()
    return np.maximum(heard, LEAST_LIKELY) - LEAST_LIKELY / 2
