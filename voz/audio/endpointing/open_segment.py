"""A segment that is not over yet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.endpointing.background import MIN_SILENT_SHARE
from voz.audio.endpointing.frame_levels import FRAME
from voz.audio.endpointing.pieces import pieces
from voz.audio.endpointing.segment import Segment

CONTINUE_ABOVE = 3.0
"""Level above the background at its start, dB; what is quieter is not part of it."""

MIN_LOUD_FRAMES = 4
"""Frames of a segment that stand out, 0.12 s; fewer are a click."""

END_FRAMES = 8
"""Frames without a voice that end a segment."""

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
    """A segment that is not over yet.

    Attributes:
        start: in the stream, samples.
        least: the level that continues it, dB.
        voices: share of the time before it that a voice may be in.
        before: highest level shortly before it, dB.
        levels: of each frame, dB.
        loud: number of frames that stood out.
        loudest: highest level, dB.
        low: frames since the level was last high enough.
        silent: frames since the last one with a voice.
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
        """Whether it has been silent for long enough."""
        return self.silent >= END_FRAMES

    @property
    def is_click(self) -> bool:
        """Whether it is still too short for speech."""
        return self.loud < MIN_LOUD_FRAMES

    def paused_at(self, heard: int) -> int:
        """Where it paused, given the position in the stream, samples."""
        return min(heard, heard - self.silent * FRAME + SEGMENT_MARGIN)

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
            )

    def segment(
        self, end: int, heard: int, kept: Samples, kept_from: int, before: int = CONTEXT_SAMPLES
    ) -> Segment:
        """Make the segment from `start` to `end`; all positions are samples of the stream.

        Args:
            end: of the segment.
            heard: the position of now.
            kept: the last samples of the stream.
            kept_from: where these begin.
            before: how many samples before it to keep with it.
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
            before=kept[max(0, first - before) : first].copy(),
            after=kept[last : min(last + CONTEXT_SAMPLES, heard - kept_from)].copy(),
        )
