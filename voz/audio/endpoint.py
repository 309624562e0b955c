"""Where speech begins and ends in a stream of samples: pocketsphinx's end-pointer, with margins."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from pocketsphinx import Endpointer

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError

# Of 239 commands by 35 voices and 78 by people (`stop` over phones), the end-pointer's defaults
# (mode 0, ratio 0.9) lose 37, nearly all of them short words of people, and join commands that are
# 0.3 s apart. These settings lose 2, cut none in two, and separate at 0.3 s.
VAD_MODE = 2
WINDOW = 0.3  # s
RATIO = 0.7  # of the window that must be speech to begin, or silence to end

MARGIN = int(0.1 * SAMPLE_RATE)
"""Kept on either side of the speech; 0.3 s, or none at all, costs accuracy."""

LONGEST = 10 * SAMPLE_RATE
"""A sentence of 12 words takes 6 s; what goes on for longer is cut here, to bound the memory."""

FRAME = 480
"""The 30 ms that the end-pointer looks at."""

LOOK_BACK = int(WINDOW * SAMPLE_RATE) + MARGIN + FRAME
"""Speech that begins now may have begun so long ago."""


PAUSE = int(0.6 * SAMPLE_RATE)
"""Between two segments, with their margins: in a sentence people pause for less."""

QUIET_KNOWN = PAUSE + LOOK_BACK
"""After a segment, until speech that began within the pause would have been noticed."""


class Segment(NamedTuple):
    """A stretch of speech.

    Attributes:
        start: where it begins in the stream, s.
        end: where it ends in the stream, s.
        decided: how much of the stream had been heard when its end was known, s.
        samples: the sound, with a margin on either side.
    """

    start: float
    end: float
    decided: float
    samples: Samples


class Quiet(NamedTuple):
    """After a segment there was no other for a while.

    Attributes:
        decided: how much of the stream had been heard when that was known, s.
    """

    decided: float


Sound = Segment | Quiet


class Segmenter:
    """Cuts one stream of samples, fed block by block, into stretches of speech."""

    def __init__(self) -> None:
        self._endpointer = Endpointer(WINDOW, RATIO, VAD_MODE, SAMPLE_RATE, FRAME / SAMPLE_RATE)
        self._kept: Samples = np.empty(0, np.int16)  # what a segment may still need
        self._kept_from = 0  # where that begins in the stream, in samples
        self._heard = 0  # samples that the end-pointer has seen
        self._start: int | None = None  # of the segment under way, in samples
        self._last_end = 0
        self._quiet_told = True  # about the silence after the last segment

    def feed(self, block: Samples) -> Iterator[Sound]:
        """Take the next samples of the stream.

        Args:
            block: any number of samples, 16 kHz.

        Yields:
            The segments whose end is known by now, and once after each that it stayed quiet.
        """
        self._kept = np.concatenate([self._kept, block])
        while len(rest := self._unheard()) >= FRAME:
            self._endpointer.process(rest[:FRAME].tobytes())
            self._heard += FRAME
            yield from self._progress()
        self._forget()

    def finish(self) -> Iterator[Sound]:
        """End the stream; yields the segment under way, if any, and that nothing follows."""
        rest = self._unheard()
        # The end-pointer refuses an empty frame.
        self._endpointer.end_stream(rest.tobytes() or b"\0\0")
        self._heard += len(rest)
        yield from self._progress()
        yield from self._quiet()

    def _unheard(self) -> Samples:
        return self._kept[self._heard - self._kept_from :]

    def _progress(self) -> Iterator[Sound]:
        """Follow the end-pointer after it has seen a frame."""
        if self._start is None and self._endpointer.in_speech:
            begun = int(self._endpointer.speech_start * SAMPLE_RATE)
            self._start = max(self._last_end, begun - MARGIN)
        elif self._start is not None and not self._endpointer.in_speech:
            end = int(self._endpointer.speech_end * SAMPLE_RATE) + MARGIN
            yield self._cut(self._start, min(end, self._heard))
            self._start = None
        elif self._start is not None and self._heard - self._start >= LONGEST:
            yield self._cut(self._start, self._heard)
            self._start = self._heard
        elif self._start is None and self._heard - self._last_end > QUIET_KNOWN:
            yield from self._quiet()

    def _quiet(self) -> Iterator[Quiet]:
        if not self._quiet_told:
            self._quiet_told = True
            yield Quiet(self._heard / SAMPLE_RATE)

    def _cut(self, start: int, end: int) -> Segment:
        self._last_end = end
        self._quiet_told = False
        samples = self._kept[start - self._kept_from : end - self._kept_from]
        return Segment(
            start / SAMPLE_RATE, end / SAMPLE_RATE, self._heard / SAMPLE_RATE, samples.copy()
        )

    def _forget(self) -> None:
        needed = self._heard - LOOK_BACK if self._start is None else self._start
        surplus = needed - self._kept_from
        if surplus > 0:
            self._kept = self._kept[surplus:]
            self._kept_from = needed


def follow_closely(one: Segment, other: Segment) -> bool:
    """Tell whether the second segment belongs to the same speech as the first."""
    return other.start - one.end < PAUSE / SAMPLE_RATE


def segments(blocks: Iterable[Samples]) -> Iterator[Segment]:
    """Cut a whole recording into stretches of speech; else as `sounds`."""
    return (sound for sound in sounds(blocks) if isinstance(sound, Segment))


def sounds(blocks: Iterable[Samples]) -> Iterator[Sound]:
    """Cut a whole recording into stretches of speech, and tell after which it stays quiet.

    Args:
        blocks: its samples, 16 kHz, in blocks of any size.

    Yields:
        Each segment as soon as its end is known, and the quiet after it as soon as it is sure.

    Raises:
        AudioError: the blocks end in one; what was heard up to there is yielded first.
    """
    segmenter = Segmenter()
    failure = None
    try:
        for block in blocks:
            yield from segmenter.feed(block)
    except AudioError as error:
        failure = error
    yield from segmenter.finish()
    if failure:
        raise failure
