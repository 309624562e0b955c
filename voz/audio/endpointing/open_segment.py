"""A stretch of sound that stands out of the room, while it goes on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.endpointing.background import MIN_SILENT_SHARE
from voz.audio.endpointing.frame_levels import FRAME
from voz.audio.endpointing.pieces import pieces
from voz.audio.endpointing.segment import Segment

CONTINUE_ABOVE = 3.0
"""Above the background that it began in, dB: less is no longer part of it."""

MIN_LOUD_FRAMES = 4
"""Frames of a segment that stand out: 0.12 s. Less is a click."""

END_FRAMES = 8
"""Frames of the VAD that must not stand out to end."""

HANGOVER_FRAMES = 3
"""Frames that go on being part of it when their level falls: a stop within a word is no pause.

The VAD has its own, of as much.
"""

SEGMENT_MARGIN = int(0.1 * SAMPLE_RATE)
"""Samples kept on either side of the speech; 0.3 s, or none at all, costs accuracy."""

CONTEXT_SAMPLES = int(0.25 * SAMPLE_RATE)
"""Samples on either side of these that the network hears too: in noise half of the segments begin
or end too late or too early. Without them it understands .84 of commands in babble at 10 dB where
it understands .94 with them; with twice as much, .94 too, and less above one talker."""

TALK_WINDOW = int(2.5 * SAMPLE_RATE)
TALK_LEVEL_RANGE = 7.0
"""Talk that goes on is as loud as what stands out of it now: of 300 stretches of it 95 in 100 have
been less than 8 dB louder than the loudest of the 2.5 s before, and of commands at 10 dB over six
people or 15 dB over one, 5 in 100."""


@dataclass
class OpenSegment:
    """A segment that is not over yet.

    Attributes:
        start: where it begins in the stream, in samples.
        least: the level that goes on with it, dB.
        voices: the share of the time before it, 0 to 1, that a voice may have been in.
        before: the highest level near before it, dB.
        levels: of each frame of it, dB.
        loud: frames of it that stood out.
        loudest: the highest level of it, dB.
        low: frames since it was loud enough to go on.
        silent: frames since the last that was part of it.
    """

    start: int
    least: float
    voices: float
    before: float
    levels: list[float]
    loud: int
    loudest: float = 0.0
    low: int = 0
    silent: int = 0

    def follow(self, voice: bool, level: float) -> None:
        """Take the next frame: whether a voice may be in it, and its level, dB."""
        self.levels.append(level)
        self.low = 0 if level > self.least else self.low + 1
        self.loud += voice and not self.low
        self.loudest = max(self.loudest, level)
        self.silent = 0 if voice and self.low <= HANGOVER_FRAMES else self.silent + 1

    @property
    def ended(self) -> bool:
        """Whether it has been silent for long enough to be over."""
        return self.silent >= END_FRAMES

    @property
    def is_click(self) -> bool:
        """Whether it is too short for speech, so far."""
        return self.loud < MIN_LOUD_FRAMES

    def paused_at(self, heard: int) -> int:
        """Tell where in the stream it paused, given how much of that was heard, in samples."""
        return min(heard, heard - self.silent * FRAME + SEGMENT_MARGIN)

    def divided(self, heard: int) -> Iterator[OpenSegment]:
        """Find the utterances in what goes on for longer than any; the last one may go on.

        Args:
            heard: how much of the stream was heard, in samples.
        """
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
            )

    def segment(self, end: int, heard: int, kept: Samples, kept_from: int) -> Segment:
        """Tell what was found.

        Args:
            end: where it ends in the stream, in samples.
            heard: how much of the stream was heard, in samples.
            kept: what is remembered of the stream; its sound and what was around it.
            kept_from: where that begins in the stream, in samples.
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
            amid=never_quiet and self.loudest < self.before + TALK_LEVEL_RANGE,
            before=kept[max(0, first - CONTEXT_SAMPLES) : first].copy(),
            after=kept[last : min(last + CONTEXT_SAMPLES, heard - kept_from)].copy(),
        )
