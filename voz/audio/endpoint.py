"""Where speech begins, pauses and ends in a stream of samples: WebRTC's VAD, with margins."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from pocketsphinx import Vad

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError

# Of 239 commands by 35 voices and 78 by people (`stop` over phones), the defaults of pocketsphinx's
# end-pointer (mode 0, ratio 0.9) lose 37, nearly all of them short words of people, and join
# commands that are 0.3 s apart. These settings lose 2, cut none in two, and separate at 0.3 s.
VAD_MODE = 2
FRAMES = 10
"""In the window that tells: of 30 ms each, 0.3 s."""

TO_BEGIN = 8
"""Frames of the window that must be speech to begin."""

TO_GO_ON = 3
"""Frames of the window that must be speech to go on."""

MARGIN = int(0.1 * SAMPLE_RATE)
"""Kept on either side of the speech; 0.3 s, or none at all, costs accuracy."""

LONGEST = 10 * SAMPLE_RATE
"""A sentence of 12 words takes 6 s; what goes on for longer is cut here, to bound the memory."""

FRAME = 480
"""The 30 ms that the VAD looks at."""

WINDOW = FRAMES * FRAME

LOOK_BACK = WINDOW + MARGIN + FRAME
"""Speech that begins now may have begun so long ago."""


PAUSE = int(0.6 * SAMPLE_RATE)
"""Between two segments, with their margins: in a sentence people pause for less."""

FIRST_SIGN = PAUSE + MARGIN + 2 * FRAME
"""After a segment, until speech that began within the pause has made a frame of the VAD speech."""

QUIET_KNOWN = PAUSE + LOOK_BACK
"""After a segment, until speech that began within the pause is a segment."""


class Segment(NamedTuple):
    """A stretch of speech.

    Attributes:
        start: where it begins in the stream, s.
        end: where it ends in the stream, s.
        decided: how much of the stream had been heard when its end was known, s.
        samples: the sound, with a margin on either side.
        over: whether it is known to be over; if not, it has paused and may go on.
    """

    start: float
    end: float
    decided: float
    samples: Samples
    over: bool = True


class Quiet(NamedTuple):
    """After a segment there was no other for a while.

    Attributes:
        decided: how much of the stream had been heard when that was known, s.
    """

    decided: float


Sound = Segment | Quiet

Found = TypeVar("Found", covariant=True)


class Feedable(Protocol[Found]):
    """What takes a recording block by block."""

    def feed(self, block: Samples) -> Iterator[Found]:
        """Take the next samples, 16 kHz; yields what is known by them."""

    def finish(self) -> Iterator[Found]:
        """End the stream; yields what was still open."""


class Segmenter:
    """Cuts one stream of samples, fed block by block, into stretches of speech."""

    def __init__(self, early: float | None = None) -> None:
        """Start with nothing heard.

        Args:
            early: a segment that has paused for so long is yielded before it is over, s; None
                yields whole ones only.
        """
        self._vad = Vad(VAD_MODE, SAMPLE_RATE, FRAME / SAMPLE_RATE)
        self._window: deque[bool] = deque(maxlen=FRAMES)  # which frames were speech
        self._pause = None if early is None else max(1, round(early * SAMPLE_RATE / FRAME))
        self._silent = 0  # frames since the last speech
        self._kept: Samples = np.empty(0, np.int16)  # what a segment may still need
        self._kept_from = 0  # where that begins in the stream, in samples
        self._heard = 0  # samples that the VAD has seen
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
            self._heard += FRAME
            yield from self._progress(self._vad.is_speech(rest[:FRAME].tobytes()))
        self._forget()

    def finish(self) -> Iterator[Sound]:
        """End the stream; yields the segment under way, if any, and that nothing follows."""
        self._heard += len(self._unheard())
        if self._start is not None:
            yield self._over(self._paused_at())
        yield from self._quiet()

    def cut(self) -> None:
        """Take the segment that has paused for over; what follows is another."""
        if self._start is not None:
            self._last_end = self._paused_at()
            self._start = None
            self._quiet_told = False
            self._window.clear()

    def _unheard(self) -> Samples:
        return self._kept[self._heard - self._kept_from :]

    def _progress(self, speaks: bool) -> Iterator[Sound]:
        """Follow the VAD by a frame."""
        self._window.append(speaks)
        self._silent = 0 if speaks else self._silent + 1
        if self._start is None and sum(self._window) >= TO_BEGIN:
            self._start = max(self._last_end, self._heard - len(self._window) * FRAME - MARGIN)
        elif self._start is None:
            since = self._heard - self._last_end
            if since > QUIET_KNOWN or (since > FIRST_SIGN and not any(self._window)):
                yield from self._quiet()
        elif sum(self._window) < TO_GO_ON:
            yield self._over(self._heard - WINDOW + FRAME + MARGIN)
        elif self._heard - self._start >= LONGEST:
            yield self._over(self._heard)
            self._start = self._heard
        elif self._silent == self._pause:
            yield self._segment(self._start, self._paused_at())._replace(over=False)

    def _paused_at(self) -> int:
        return min(self._heard, self._heard - self._silent * FRAME + MARGIN)

    def _quiet(self) -> Iterator[Quiet]:
        if not self._quiet_told:
            self._quiet_told = True
            yield Quiet(self._heard / SAMPLE_RATE)

    def _over(self, end: int) -> Segment:
        assert self._start is not None
        segment = self._segment(self._start, end)
        self._last_end = end
        self._start = None
        self._quiet_told = False
        return segment

    def _segment(self, start: int, end: int) -> Segment:
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
    return through(Segmenter(), blocks)


def through(stream: Feedable[Found], blocks: Iterable[Samples]) -> Iterator[Found]:
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
