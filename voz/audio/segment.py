"""What a segmenter finds in a stream: segments, pauses, segments that go on."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.levels import FRAME, MIN_SILENT_SHARE, BandLevels, LevelMeter, quantile
from voz.errors import AudioError

STEADY_QUANTILE = 0.5
"""Quantile of the levels that is the steady noise: motors, or a radio."""


class Piece(NamedTuple):
    """Frames that stand out: the first, and the one after the last."""

    start: int
    end: int


def pieces(levels: Sequence[float], above: float, pause: int) -> tuple[float, list[Piece]]:
    """Find what stands out of a steady noise.

    Returns the level of the noise and the pieces in order; levels are dB, the pause between two
    pieces is in quiet frames.
    """
    usual = float(quantile(levels, STEADY_QUANTILE))
    found: list[Piece] = []
    for frame, level in enumerate(levels):
        if level <= usual + above:
            continue
        if found and frame - found[-1].end < pause:
            found[-1] = Piece(found[-1].start, frame + 1)
        else:
            found.append(Piece(frame, frame + 1))
    return usual, found


MAX_WORD_SECONDS = 0.7
"""Length of a slowly spoken word."""

MAX_PAUSE_SAMPLES = int(0.6 * SAMPLE_RATE)
"""Between two segments of one sentence, margins included."""


NO_SAMPLES: Samples = np.empty(0, np.int16)


class Segment(NamedTuple):
    """A stretch of speech."""

    start: float  # in the stream, s
    end: float  # in the stream, s
    decided: float  # position in the stream when the end was known, s
    samples: Samples  # the sound, with a margin on either side
    over: bool = True  # whether it is over; if not, it has paused and may go on
    above: float = math.inf  # how far its loudest frame is above the background, dB
    voices: float = 0.0  # share of the time before it that a voice may be in
    within_talk: bool = False  # whether it stands within talk that is as loud
    # Sound before the samples, up to 0.25 s; longer where the robot has a name.
    before: Samples = NO_SAMPLES
    # Sound after them, as far as it is known; up to 0.25 s, or longer for a name.
    after: Samples = NO_SAMPLES

    @property
    def with_surroundings(self) -> Samples:
        """The samples with the sound before and after them."""
        return np.concatenate([self.before, self.samples, self.after])

    def joined(self, other: Segment) -> Segment:
        """This segment, the pause after it and the next one, whose `before` holds the pause."""
        pause = round((other.start - self.end) * SAMPLE_RATE)
        between = other.before[len(other.before) - pause :]
        return other._replace(
            start=self.start,
            samples=np.concatenate([self.samples, between, other.samples]),
            above=max(self.above, other.above),
            voices=self.voices,
            within_talk=self.within_talk,
            before=self.before,
        )

    @property
    def level(self) -> float:
        """Level of its loudest frame, 250 to 3,400 Hz, dB over one unit of 16 bits."""
        frames = LevelMeter().measure(self.samples[: len(self.samples) // FRAME * FRAME])
        return max((low for low, _ in frames), default=0.0)


@dataclass(frozen=True)
class Quiet:
    """No segment followed the last one."""

    decided: float  # position in the stream when that was known, s
    samples: Samples = field(compare=False)  # the sound since the segment's end


@dataclass(frozen=True)
class Ongoing:
    """The sound of a segment so far; comes again until it is over."""

    decided: float  # position in the stream, s
    samples: Samples  # from the segment's start, 0.7 s at least


SegmenterEvent = Segment | Quiet | Ongoing

Found = TypeVar("Found", covariant=True)


class Feedable(Protocol[Found]):
    """Takes a recording block by block."""

    def feed(self, block: Samples) -> Iterator[Found]:
        """Take the next samples, 16 kHz; yields what was found."""

    def finish(self) -> Iterator[Found]:
        """End the stream; yields what was still open."""


MAX_LEVEL_DROP = 6.0
"""Within a sentence a part is quieter than another by this at most, dB; somebody else is farther.
"""


def belong_together(one: Segment, other: Segment) -> bool:
    """Whether two segments, in any order, are close enough to be one sentence."""
    pause = max(one.start, other.start) - min(one.end, other.end)
    return pause < MAX_PAUSE_SAMPLES / SAMPLE_RATE


def is_spoken_with(command: Segment, other: Segment) -> bool:
    """Whether another segment is close to a command, and loud enough to be of the same speaker."""
    return belong_together(command, other) and other.level >= command.level - MAX_LEVEL_DROP


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


CONTINUE_ABOVE = 3.0
"""Level above the background at its start, dB; what is quieter is not part of it."""

MIN_LOUD_FRAMES = 4
"""Frames of a segment that stand out, 0.12 s; fewer are a click."""

END_FRAMES = 8
"""Frames without a voice, or a hiss after it, that end a segment."""

HANGOVER_FRAMES = 3
"""Quiet frames within a word, as before a plosive, that do not pause a segment."""

SEGMENT_MARGIN = int(0.1 * SAMPLE_RATE)
"""Samples kept on either side of the speech; 0.3 s, or none, costs accuracy."""

CONTEXT_SAMPLES = int(0.25 * SAMPLE_RATE)
"""Samples beyond the margin that the network hears, too.

In noise half of the segments begin or end too late or too early: 84 of 100 commands in babble at
10 dB are understood without these, 94 with them.
"""


TALK_WINDOW = int(2.5 * SAMPLE_RATE)
TALK_LEVEL_RANGE = 7.0
"""Talk goes on at much the same level, commands stand out of it, dB.

Of 300 stretches of talk 95 in 100 were less than 8 dB above the loudest of the 2.5 s before, of
commands at 10 dB over six people 5 in 100.
"""


@dataclass
class OpenSegment:
    """A segment that is not over yet."""

    start: int  # in the stream, samples
    least: float  # the level that continues it, 250 to 3,400 Hz, dB
    voices: float  # share of the time before it that a voice may be in
    before: float  # highest level shortly before it, dB
    levels: list[float]  # of each frame, dB
    loud: int  # number of frames that stood out
    loudest: float = 0.0  # highest level, dB
    least_high: float = math.inf  # the level from there to 7,000 Hz that stands out, dB
    low: int = 0  # frames since the level was last high enough
    silent: int = 0  # frames since the last one with a voice
    quiet: int = 0  # frames since the last one with a voice or a sound as soft as the end of `off`

    def follow(self, voice: bool, level: BandLevels) -> None:
        """Take the next frame: whether a voice may be in it, and its levels, dB."""
        low, high = level
        hisses = high > self.least_high
        self.levels.append(low)
        self.low = 0 if low > self.least else self.low + 1
        self.loud += voice and (hisses or not self.low)
        self.loudest = max(self.loudest, low)
        self.silent = 0 if voice and self.low <= HANGOVER_FRAMES else self.silent + 1
        self.quiet = 0 if not self.silent or (voice and hisses) else self.quiet + 1

    @property
    def ended(self) -> bool:
        """Whether it has been quiet for long enough."""
        return self.quiet >= END_FRAMES

    @property
    def is_click(self) -> bool:
        """Whether it is still too short for speech."""
        return self.loud < MIN_LOUD_FRAMES

    def paused_at(self, heard: int) -> int:
        """Where it paused, given the position in the stream, samples."""
        return min(heard, heard - self.silent * FRAME + SEGMENT_MARGIN)

    def ended_at(self, heard: int) -> int:
        """Where it ended, given the position in the stream, samples."""
        return min(heard, heard - self.quiet * FRAME + SEGMENT_MARGIN)

    def divide(self, heard: int) -> Iterator[OpenSegment]:
        """Split an overlong segment at its quiet parts; the last part may go on."""
        first = heard - len(self.levels) * FRAME
        before = self.before
        usual, found = pieces(self.levels, CONTINUE_ABOVE, END_FRAMES)
        for piece in found:
            frames = piece.end - piece.start
            if frames < MIN_LOUD_FRAMES:
                continue
            before = max(
                [before, *self.levels[max(0, piece.start - TALK_WINDOW // FRAME) : piece.start]]
            )
            silent = len(self.levels) - piece.end
            yield OpenSegment(
                start=first + piece.start * FRAME - SEGMENT_MARGIN,
                least=usual + CONTINUE_ABOVE,
                voices=self.voices,
                before=before,
                levels=self.levels[piece.start :],
                loud=frames,
                loudest=max(self.levels[slice(*piece)]),
                low=silent,
                silent=silent,
                quiet=silent,
            )

    def segment(
        self, end: int, heard: int, kept: Samples, kept_from: int, before: int = CONTEXT_SAMPLES
    ) -> Segment:
        """Make the segment from `start` to `end`, with `before` samples before it.

        All positions are samples of the stream: `heard` is now, `kept` its last ones from
        `kept_from`.
        """
        first, last = self.start - kept_from, end - kept_from
        never_quiet = self.voices > 1 - MIN_SILENT_SHARE
        return Segment(
            self.start / SAMPLE_RATE,
            end / SAMPLE_RATE,
            heard / SAMPLE_RATE,
            kept[first:last].copy(),
            above=self.loudest - self.least + CONTINUE_ABOVE,
            voices=self.voices,
            within_talk=never_quiet and self.loudest < self.before + TALK_LEVEL_RANGE,
            before=kept[max(0, first - before) : first].copy(),
            after=kept[last : min(last + CONTEXT_SAMPLES, heard - kept_from)].copy(),
        )
