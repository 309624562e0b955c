"""What is found in a stream of samples, told as soon as it is known."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError

MAX_WORD_SECONDS = 0.7
"""Seconds; who speaks slowly says a word of a command in that."""

MAX_PAUSE_SAMPLES = int(0.6 * SAMPLE_RATE)
"""Between two segments, with their margins: in a sentence people pause for less."""


NO_SAMPLES: Samples = np.empty(0, np.int16)


class Segment(NamedTuple):
    """A stretch of speech.

    Attributes:
        start: where it begins in the stream, s.
        end: where it ends in the stream, s.
        decided: how much of the stream had been heard when its end was known, s.
        samples: the sound, with a margin on either side.
        over: whether it is known to be over; if not, it has paused and may go on.
        above: how far the loudest of it stands out of the room, dB.
        voices: the share of the time before it, 0 to 1, that a voice may be in.
        amid: whether something as loud was heard just before, in a room that is never quiet.
        before: the sound just before the samples, up to 0.25 s.
        after: the sound just after them, up to 0.25 s, as far as it has been heard.
    """

    start: float
    end: float
    decided: float
    samples: Samples
    over: bool = True
    above: float = math.inf
    voices: float = 0.0
    amid: bool = False
    before: Samples = NO_SAMPLES
    after: Samples = NO_SAMPLES

    @property
    def with_surroundings(self) -> Samples:
        """The samples with the sound before and after them."""
        return np.concatenate([self.before, self.samples, self.after])


class Quiet(NamedTuple):
    """After a segment there was no other for a while.

    Attributes:
        decided: how much of the stream had been heard when that was known, s.
    """

    decided: float


class Ongoing(NamedTuple):
    """What is part of a segment so far; told again and again until that is over.

    Attributes:
        decided: how much of the stream has been heard, s.
        samples: the sound up to there, from where the segment begins, and 0.7 s at least.
    """

    decided: float
    samples: Samples


Sound = Segment | Quiet | Ongoing

Found = TypeVar("Found", covariant=True)


class Feedable(Protocol[Found]):
    """What takes a recording block by block."""

    def feed(self, block: Samples) -> Iterator[Found]:
        """Take the next samples, 16 kHz; yields what is known by them."""

    def finish(self) -> Iterator[Found]:
        """End the stream; yields what was still open."""


def belong_together(one: Segment, other: Segment) -> bool:
    """Tell whether the second segment belongs to the same speech as the first."""
    return other.start - one.end < MAX_PAUSE_SAMPLES / SAMPLE_RATE


def feed_all(stream: Feedable[Found], blocks: Iterable[Samples]) -> Iterator[Found]:
    """Feed a whole recording to a stream and end it; an AudioError of the blocks comes last."""
    failure = None
    try:
        for block in blocks:
            yield from stream.feed(block)
    except AudioError as error:
        failure = error
    yield from stream.finish()
    if failure:
        raise failure
