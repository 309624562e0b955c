"""Where in a clip each of its known phones is said, and which of them a stretch of it holds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

EDGE = 2
"""A phone that stands so near to the edge of a stretch, moments, may be in it or not."""

Floats = npt.NDArray[np.float32]


def align(likely: Floats, phones: Sequence[int]) -> list[tuple[int, int]]:
    """Find the best alignment of known phones (Viterbi over the CTC lattice).

    Args:
        likely: moments x symbols, log-probabilities; symbol 0 is the blank.
        phones: the symbols that are said, in order, at most as many as there are moments.

    Returns:
        The first and the last moment of each phone; empty where they do not fit.
    """
    nodes = np.zeros(2 * len(phones) + 1, np.intp)
    nodes[1::2] = phones
    may_skip = np.zeros(len(nodes), np.bool_)  # from one phone to the next without a blank
    may_skip[3::2] = nodes[3::2] != nodes[1:-2:2]
    scores = np.full(len(nodes), -np.inf)
    scores[:2] = likely[0, nodes[:2]]
    came_from = np.zeros((len(likely), len(nodes)), np.intp)
    places = np.arange(len(nodes))
    for moment in range(1, len(likely)):
        stay = scores
        step = np.concatenate([[-np.inf], scores[:-1]])
        skip = np.where(may_skip, np.concatenate([[-np.inf, -np.inf], scores[:-2]]), -np.inf)
        choices = np.stack([stay, step, skip])
        moved = choices.argmax(axis=0)
        came_from[moment] = places - moved
        scores = choices[moved, places] + likely[moment, nodes]
    node = len(nodes) - 1 if scores[-1] > scores[-2] else len(nodes) - 2
    if not np.isfinite(scores[node]):
        return []
    spans = [(-1, -1)] * len(phones)
    for moment in range(len(likely) - 1, -1, -1):
        if node % 2:
            last = spans[node // 2][1]
            spans[node // 2] = (moment, moment if last < 0 else last)
        node = came_from[moment, node]
    return spans


def phones_within(
    spans: Sequence[tuple[int, int]], phones: Sequence[str], begin: int, end: int
) -> tuple[str, ...] | None:
    """The phones said from one moment to before another; None where one is cut at the edge."""
    found = []
    for (first, last), phone in zip(spans, phones, strict=True):
        if begin + EDGE <= first and last < end - EDGE:
            found.append(phone)
        elif first < end + EDGE and last >= begin - EDGE:
            return None
    return tuple(found) or None
