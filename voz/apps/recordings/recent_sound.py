"""The last seconds of a stream, from which the sound of utterances is cut. Pure."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.events import Utterance

EXCERPT_MARGIN = int(0.3 * SAMPLE_RATE)
"""Samples on either side, with which the end-pointer finds the same speech in it."""

LONGEST_KEPT = 30 * SAMPLE_RATE
"""Samples: an utterance of 10 s may be settled only after the next one of 10 s."""


@dataclass(frozen=True)
class Excerpt:
    """What was heard, and its sound."""

    utterance: Utterance
    samples: Samples


class RecentSound:
    """Takes a stream block by block, and returns the sound of its utterances."""

    def __init__(self) -> None:
        self._blocks: deque[Samples] = deque()
        self._begin = 0  # of `_blocks` in the stream, in samples
        self._end = 0
        self._open: list[tuple[int, int, Utterance]] = []  # their sound is not complete yet

    def feed(self, block: Samples) -> Iterator[Excerpt]:
        """Take the next samples, 16 kHz; yields marked utterances whose sound is complete."""
        self._blocks.append(block)
        self._end += len(block)
        while self._end - self._begin - len(self._blocks[0]) >= LONGEST_KEPT:
            self._begin += len(self._blocks.popleft())
        yield from self._cut([piece for piece in self._open if piece[1] <= self._end])

    def mark(self, start: float, end: float, utterance: Utterance) -> None:
        """Ask for the sound of an utterance from `start` to `end` of the stream, s."""
        first, last = round(start * SAMPLE_RATE), round(end * SAMPLE_RATE)
        self._open.append((first - EXCERPT_MARGIN, last + EXCERPT_MARGIN, utterance))

    def finish(self) -> Iterator[Excerpt]:
        """End the stream; yields what is still open, with the sound that there is."""
        yield from self._cut(list(self._open))

    def _cut(self, pieces: list[tuple[int, int, Utterance]]) -> Iterator[Excerpt]:
        for piece in pieces:
            self._open.remove(piece)
            first, last, utterance = piece
            samples = np.concatenate(self._blocks) if self._blocks else np.empty(0, np.int16)
            begin, end = max(0, first - self._begin), max(0, last - self._begin)
            if len(samples[begin:end]):
                yield Excerpt(utterance, samples[begin:end].copy())
