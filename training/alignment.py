"""Where in a clip each of its known phones is said, and which of them a stretch of it holds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

EDGE = 2
"""A phone that stands so near to the edge of a stretch, moments, may be in it or not."""

Floats = npt.NDArray[np.float32]


def align(likely: Floats, phones: Sequence[Sequence[int]]) -> list[list[tuple[int, int]]]:
    """Find the best alignment of the known phones of each clip (Viterbi over the CTC lattice).

    Args:
        likely: clips x moments x symbols, log-probabilities; symbol 0 is the blank.
        phones: the symbols that are said in each clip, in order, one or more.

    Returns:
        For each clip the first and the last moment of each phone; empty where they do not fit.
    """
    nodes = np.zeros((len(phones), 2 * max(map(len, phones)) + 1), np.intp)
    for row, said in zip(nodes, phones, strict=True):
        row[1 : 2 * len(said) : 2] = said
    may_skip = np.zeros(nodes.shape, np.bool_)  # from one phone to the next without a blank
    may_skip[:, 3::2] = nodes[:, 3::2] != nodes[:, 1:-2:2]
    emitted = np.take_along_axis(likely, nodes[:, None], axis=2)
    scores = np.full(nodes.shape, -np.inf)
    scores[:, :2] = emitted[:, 0, :2]
    steps = np.zeros(emitted.shape, np.int8)  # how many nodes further than the moment before
    for moment in range(1, emitted.shape[1]):
        stay, skip = scores, np.full(nodes.shape, -np.inf)
        step = np.pad(scores[:, :-1], ((0, 0), (1, 0)), constant_values=-np.inf)
        skip[:, 2:] = np.where(may_skip[:, 2:], scores[:, :-2], -np.inf)
        choices = np.stack([stay, step, skip])
        steps[:, moment] = choices.argmax(axis=0)
        scores = choices.max(axis=0) + emitted[:, moment]
    return [
        _followed_back(each, score[: 2 * len(said) + 1])
        for each, score, said in zip(steps, scores, phones, strict=True)
    ]


def _followed_back(steps: npt.NDArray[np.int8], scores: Floats) -> list[tuple[int, int]]:
    """The spans of one clip's phones, from how its best path came to each node."""
    node = len(scores) - 1 if scores[-1] > scores[-2] else len(scores) - 2
    if not np.isfinite(scores[node]):
        return []
    spans = [(-1, -1)] * (len(scores) // 2)
    for moment in range(len(steps) - 1, -1, -1):
        if node % 2:
            last = spans[node // 2][1]
            spans[node // 2] = (moment, moment if last < 0 else last)
        node -= int(steps[moment, node])
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
