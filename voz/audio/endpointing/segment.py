"""What a segmenter finds in a stream: segments, pauses, segments that go on."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError

MAX_WORD_SECONDS = 0.7
"""Length of a slowly spoken word."""

MAX_PAUSE_SAMPLES = int(0.6 * SAMPLE_RATE)
"""Between two segments of one sentence, margins included."""


NO_SAMPLES: Samples = np.empty(0, np.int16)


class Segment(NamedTuple):
    """A stretch of speech.

    Attributes:
        start: in the stream, s.
        end: in the stream, s.
        decided: position in the stream when the end was known, s.
        samples: the sound, with a margin on either side.
        over: whether it is over; if not, it has paused and may go on.
        above: how far its loudest frame is above the background, dB.
        voices: share of the time before it that a voice may be in.
        amid: whether it stands within talk that is as loud.
        before: sound before the samples, up to 0.25 s; longer where the robot has a name.
        after: sound after them, as far as it is known; up to 0.25 s, or longer for a name.
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


@dataclass(frozen=True)
class Quiet:
    """No segment followed the last one.

    Attributes:
        decided: position in the stream when that was known, s.
        samples: the sound since the segment's end.
    """

    decided: float
    samples: Samples = field(compare=False)


@dataclass(frozen=True)
class Ongoing:
    """The sound of a segment so far; comes again until it is over.

    Attributes:
        decided: position in the stream, s.
        samples: from the segment's start, 0.7 s at least.
    """

    decided: float
    samples: Samples


Sound = Segment | Quiet | Ongoing

Found = TypeVar("Found", covariant=True)


class Feedable(Protocol[Found]):
    """Takes a recording block by block."""

    def feed(self, block: Samples) -> Iterator[Found]:
        """Take the next samples, 16 kHz; yields what was found."""

    def finish(self) -> Iterator[Found]:
        """End the stream; yields what was still open."""


def belong_together(one: Segment, other: Segment) -> bool:
    """Whether two segments are close enough to be one sentence."""
    return other.start - one.end < MAX_PAUSE_SAMPLES / SAMPLE_RATE


def feed_all(stream: Feedable[Found], blocks: Iterable[Samples]) -> Iterator[Found]:
    """Feed a whole recording and end the stream; then raise an AudioError of the blocks."""
    failure = None
    try:
        for block in blocks:
            yield from stream.feed(block)
    except AudioError as error:
        failure = error
    yield from stream.finish()
    if failure:
        raise failure
