"""Finds where speech begins, pauses and ends in a stream."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator

import numpy as np
from pocketsphinx import Vad

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.levels import (
    FRAME,
    RISE_FRAMES,
    STEADY_FRAMES,
    Background,
    BandLevels,
    LevelMeter,
    SteadyNoise,
)
from voz.audio.segment import (
    CONTEXT_SAMPLES,
    CONTINUE_ABOVE,
    MAX_PAUSE_SAMPLES,
    MAX_WORD_SECONDS,
    SEGMENT_MARGIN,
    TALK_WINDOW,
    Ongoing,
    OpenSegment,
    Quiet,
    Segment,
    SegmenterEvent,
    feed_all,
)
from voz.audio.voice_detector import RUN_UP, shared_voice_detector

VAD_MODE = 2
"""WebRTC's; of 317 commands all but 2 are speech to it."""

BEGIN_ABOVE = 6.0
"""Level above the background that begins a segment, dB."""

MAX_STEADY_RANGE, MAX_NOISE_RANGE = 7.0, 16.0
"""How much a noise may change in 0.4 s, dB: any noise, and one that is surely no voice.

Motors change by 5 to 12, vowels by as little as 3.
"""

MAX_NOISE_PROBABILITY = 0.4
"""Of speech; less is surely no voice."""

BEGIN_FRAMES = 2
"""Frames in a row that stand out and begin a segment, 60 ms."""

ONGOING_INTERVAL = 6
"""Frames between two `Ongoing`, 0.18 s."""

ONSET_FRAMES = 8
"""What stood out in the last 0.24 s, as the s of `speed`, belongs to what begins."""

MAX_SEGMENT_SECONDS = 10.0
"""A sentence of 12 words takes 6; what is longer is split."""

ONSET_SAMPLES = ONSET_FRAMES * FRAME + SEGMENT_MARGIN
"""A segment may begin this long before it is noticed."""

MIN_KEPT_SAMPLES = int(MAX_WORD_SECONDS * SAMPLE_RATE)
"""A word may have begun before the segment's start."""

QUIET_AFTER = MAX_PAUSE_SAMPLES + SEGMENT_MARGIN + 2 * FRAME
"""Samples after a segment until a sound that began within the pause stands out."""

QUIET_AFTER_ONSET = MAX_PAUSE_SAMPLES + ONSET_SAMPLES
"""Samples after a segment until a sound that began within the pause is a segment."""


class Segmenter:
    """Divides one stream of samples into stretches of speech."""

    def __init__(
        self,
        early: float | None = None,
        longest: float = MAX_SEGMENT_SECONDS,
        before: int = CONTEXT_SAMPLES,
    ) -> None:
        """Start a stream.

        Args:
            early: segments that have paused for this time are yielded before they are over, s,
                and `Ongoing` meanwhile; None yields whole ones only.
            longest: longer segments are split, s.
            before: samples before a segment that are kept with it.
        """
        self._before = before
        self._least_kept = max(MIN_KEPT_SAMPLES, before + ONSET_SAMPLES)
        self._longest = int(longest * SAMPLE_RATE)
        self._detector = Vad(VAD_MODE, SAMPLE_RATE, FRAME / SAMPLE_RATE)
        self._loudness = LevelMeter()
        self._background = Background()
        self._pause = None if early is None else max(1, round(early * SAMPLE_RATE / FRAME))
        self._stood: deque[bool] = deque(maxlen=ONSET_FRAMES)  # which frames stood out at all
        self._standing = 0  # frames that stood out, up to now
        self._began_above: BandLevels = (0.0, 0.0)  # the background of the last segment's beginning
        self._rest_expected = False  # of a sentence that has paused
        self._kept: Samples = np.empty(0, np.int16)  # what a segment may still need
        self._kept_from = 0  # where that begins in the stream, in samples
        self._heard = 0  # samples that the VAD has seen
        self._open: OpenSegment | None = None  # the segment that goes on
        self._command_until = 0  # all sound up to here was for the robot
        self._last_end = 0
        self._quiet_reported = True  # about the silence after the last segment

    def feed(self, block: Samples) -> Iterator[SegmenterEvent]:
        """Take the next samples of the stream, 16 kHz, any number of them.

        Yields:
            Segments whose end is known, and after each once that nothing followed.
        """
        self._kept = np.concatenate([self._kept, block])
        unread = self._unread()
        whole = unread[: len(unread) // FRAME * FRAME]
        levels = self._loudness.measure(whole)
        for frame, level in zip(whole.reshape(-1, FRAME), levels, strict=True):
            self._heard += FRAME
            yield from self._take_frame(frame.tobytes(), level)
        self._forget()

    def finish(self) -> Iterator[SegmenterEvent]:
        """End the stream; yields the open segment, if any, and the quiet after it."""
        self._heard += len(self._unread())
        if self._open:
            yield self._finish_segment(self._open)
        yield from self._report_quiet()

    def cut(self) -> None:
        """End the segment that has paused; what follows is another one."""
        if self._open:
            self._end(self._open.paused_at(self._heard))
            self._standing = 0

    def expect_rest(self) -> None:
        """Let what follows the last segment begin as softly as that did, until it is quiet.

        Where noise sounds like a voice, a long sentence is taken for the background.
        """
        self._rest_expected = True

    @property
    def background(self) -> float:
        """Level of the room, dB relative to one unit of the 16 bits."""
        return self._background.level

    @property
    def in_segment(self) -> bool:
        """Whether a segment goes on."""
        return self._open is not None

    def mark_command(self) -> None:
        """Note that the sound so far was said to the robot, and is no talk of others."""
        self._command_until = self._heard

    def _unread(self) -> Samples:
        return self._kept[self._heard - self._kept_from :]

    def _take_frame(self, frame: bytes, level: BandLevels) -> Iterator[SegmenterEvent]:
        voice = self._detector.is_speech(frame)
        background = self._background.follow(level, voice)
        if self._open is None:
            yield from self._begin(voice, level, background)
        else:
            yield from self._continue(self._open, voice, level)
            if self._pause and self._open and self._heard // FRAME % ONGOING_INTERVAL == 0:
                so_far = self._kept[: self._heard - self._kept_from]
                yield Ongoing(self._heard / SAMPLE_RATE, so_far)

    def _begin(
        self, voice: bool, level: BandLevels, background: BandLevels
    ) -> Iterator[SegmenterEvent]:
        if self._rest_expected:
            rooms = (background, self._began_above)
            background = min(low for low, _ in rooms), min(high for _, high in rooms)
        low, high = (lv > room + BEGIN_ABOVE for lv, room in zip(level, background, strict=True))
        self._stood.append(low or high)
        self._standing = self._standing + 1 if voice and low else 0
        if self._standing >= BEGIN_FRAMES:
            self._start_above(background, len(self._stood) - self._stood.index(True))
            return
        since = self._heard - self._last_end
        if since > QUIET_AFTER_ONSET or (since > QUIET_AFTER and not self._standing):
            yield from self._report_quiet()

    def _start_above(self, background: BandLevels, frames: int) -> None:
        """Begin a segment `frames` ago."""
        begin = self._heard - frames * FRAME - SEGMENT_MARGIN
        since = min(TALK_WINDOW, self._heard - self._command_until) // FRAME
        self._open = OpenSegment(
            start=max(self._last_end, begin),
            least=background[0] + CONTINUE_ABOVE,
            voices=self._background.voices,
            before=self._background.loudest(since, frames),
            levels=[background[0]] * frames,
            loud=max(BEGIN_FRAMES, sum(self._stood)),
            least_high=background[1] + BEGIN_ABOVE,
        )
        self._began_above = background
        self._standing = 0
        self._stood.clear()

    def _continue(
        self, now: OpenSegment, voice: bool, level: BandLevels
    ) -> Iterator[SegmenterEvent]:
        now.follow(voice, level)
        if (noise := self._noise_under(now)) is not None:
            yield self._finish_segment(now, self._heard - RISE_FRAMES * FRAME)
            self._background.settle(noise.usual)
            self._start_above(noise.highest, RISE_FRAMES)
        elif now.ended and now.is_click:
            self._open = None
        elif now.ended:
            yield self._finish_segment(now)
        elif self._heard - now.start > self._longest:
            yield from self._divide(now)
        elif now.silent == self._pause and not now.is_click:
            yield self._segment(now, now.paused_at(self._heard))._replace(over=False)

    def _divide(self, whole: OpenSegment) -> Iterator[Segment]:
        self._open = None
        for part in whole.divide(self._heard):
            part.start = max(self._last_end, part.start)
            self._open = part
            if part.ended:
                yield self._finish_segment(part)
        if self._open is None:
            self._end(self._heard)

    def _noise_under(self, now: OpenSegment) -> SteadyNoise | None:
        """Return the noise that began the segment, if speech has just risen above it."""
        if self._heard - now.start < (STEADY_FRAMES + RISE_FRAMES) * FRAME + SEGMENT_MARGIN:
            return None
        steady = self._background.risen_above(BEGIN_ABOVE, MAX_STEADY_RANGE)
        if steady is not None:
            return steady
        noise = self._background.risen_above(BEGIN_ABOVE, MAX_NOISE_RANGE)
        return None if noise is None or self._voice_before() > MAX_NOISE_PROBABILITY else noise

    def _voice_before(self) -> float:
        end = self._heard - RISE_FRAMES * FRAME - self._kept_from
        return shared_voice_detector().probability(
            self._kept[end - STEADY_FRAMES * FRAME - RUN_UP : end]
        )

    def _report_quiet(self) -> Iterator[Quiet]:
        if not self._quiet_reported:
            self._quiet_reported, self._rest_expected = True, False
            since, now = (at - self._kept_from for at in (self._last_end, self._heard))
            yield Quiet(self._heard / SAMPLE_RATE, self._kept[max(0, since) : now])

    def _finish_segment(self, now: OpenSegment, end: int | None = None) -> Segment:
        end = now.ended_at(self._heard) if end is None else end
        segment = self._segment(now, end)
        self._end(end)
        return segment

    def _end(self, at: int) -> None:
        self._last_end = at
        self._open = None
        self._quiet_reported = self._rest_expected = False

    def _segment(self, now: OpenSegment, end: int) -> Segment:
        return now.segment(end, self._heard, self._kept, self._kept_from, self._before)

    def _forget(self) -> None:
        recent = self._heard - self._least_kept
        needed = min(recent, self._open.start - self._before) if self._open else recent
        surplus = needed - self._kept_from
        if surplus > 0:
            self._kept = self._kept[surplus:]
            self._kept_from += surplus


def segments(blocks: Iterable[Samples]) -> Iterator[Segment]:
    """The segments of a whole recording, as `sounds` yields them."""
    return (sound for sound in sounds(blocks) if isinstance(sound, Segment))


def sounds(blocks: Iterable[Samples]) -> Iterator[SegmenterEvent]:
    """Divide a whole recording, in blocks at 16 kHz, into stretches of speech.

    Yields each segment when its end is known, and the quiet after it when that is sure.
    """
    return feed_all(Segmenter(), blocks)
