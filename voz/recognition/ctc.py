"""How likely sequences of symbols are, by a network that tells one symbol or none each moment.

Connectionist temporal classification, Graves et al. 2006 (doi:10.1145/1143844.1143891): the
probabilities of all ways to spread a sequence over the moments add up. Pure.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

TINY = 1e-300
"""Of a sequence that does not fit into the moments; its logarithm is still a number."""


class Lattice(NamedTuple):
    """Sequences laid side by side, to be followed together.

    Attributes:
        symbols: of each state of each sequence; between two symbols, and at the ends, is a blank.
        skips: 1 where the blank before a state may be left out, else 0.
        lengths: the symbols of each sequence.
    """

    symbols: npt.NDArray[np.intp]
    skips: Floats
    lengths: npt.NDArray[np.intp]


def lattice(sequences: Sequence[Sequence[int]], blank: int) -> Lattice:
    """Lay sequences side by side.

    Args:
        sequences: their symbols, by number; none is empty.
        blank: the number of the blank.
    """
    states = 2 * max(map(len, sequences)) + 1
    symbols = np.full((len(sequences), states), blank)
    skips = np.zeros((len(sequences), states))
    for row, sequence in enumerate(sequences):
        symbols[row, 1 : 2 * len(sequence) : 2] = sequence
        for place in range(1, len(sequence)):
            skips[row, 2 * place + 1] = sequence[place] != sequence[place - 1]
    return Lattice(symbols, skips, np.array([len(sequence) for sequence in sequences]))


def log_likelihoods(probabilities: Floats, sequences: Lattice) -> Floats:
    """Tell how likely each sequence is.

    Args:
        probabilities: moments x symbols.
        sequences: as `lattice` lays them.

    Returns:
        A natural logarithm for each.
    """
    rows, states = sequences.symbols.shape
    emitted = probabilities[:, sequences.symbols]
    forward = np.zeros((rows, states + 2))  # two states before the first, which are never reached
    forward[:, 2:4] = emitted[0, :, :2]
    total = np.zeros(rows)
    for moment in emitted[1:]:
        scale = forward.sum(axis=1, keepdims=True) + TINY  # else the numbers become too small
        total += np.log(scale[:, 0])
        forward /= scale
        forward[:, 2:] += forward[:, 1:-1] + sequences.skips * forward[:, :-2]
        forward[:, 2:] *= moment
    last = 2 * sequences.lengths + 2  # the blank at the end
    every = np.arange(rows)
    ends = forward[every, last] + forward[every, last - 1]
    found: Floats = total + np.log(np.maximum(ends, TINY))
    return found
