"""Where speech begins, pauses and ends in a stream of samples: what stands out of the room."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import TypeAlias

import numpy as np
from pocketsphinx import Vad

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.endpointing.background import RISE_FRAMES, STEADY_FRAMES, Background, SteadyNoise
from voz.audio.endpointing.frame_levels import FRAME, BandLevels, LevelMeter
from voz.audio.endpointing.open_segment import (
    CONTEXT_SAMPLES,
    CONTINUE_ABOVE,
    SEGMENT_MARGIN,
    TALK_WINDOW,
    OpenSegment,
)
from voz.audio.endpointing.segment import (
    MAX_PAUSE_SAMPLES,
    MAX_WORD_SECONDS,
    Ongoing,
    Quiet,
    Segment,
    Sound,
    feed_all,
)
from voz.audio.endpointing.voice_detector import RUN_UP, shared_voice_detector

VAD_MODE = 2
"""Of WebRTC's detector. Of 239 commands by 35 voices and 78 by people, all but 2 are speech
to it."""

BEGIN_ABOVE = 6.0
"""Above the background, dB: what stands out so far for 60 ms begins a segment."""

MAX_STEADY_RANGE, MAX_NOISE_RANGE = 7.0, 16.0
"""By how much a sound that goes on may change in 0.4 s, dB: whatever it is, and if it is no voice.

Motors change by 5 to 12, vowels by as little as 3.
"""

MAX_NOISE_PROBABILITY = 0.4
"""Below it the voice detector is sure enough that there is none."""

BEGIN_FRAMES = 2
"""Frames of the VAD that must stand out to begin."""

ONGOING_INTERVAL = 6
"""Frames, 0.18 s, after which it is told again what there is of a segment."""

ONSET_FRAMES = 8
"""Frames, 0.24 s. What stood out within them, as the s of `speed`, belongs to what begins."""

MAX_SEGMENT_SECONDS = 10.0
"""Seconds. A sentence of 12 words takes 6; what goes on for longer is cut, to bound the memory."""

ONSET_SAMPLES = ONSET_FRAMES * FRAME + SEGMENT_MARGIN
"""What begins now may have begun so long ago."""

MIN_KEPT_SAMPLES = int(MAX_WORD_SECONDS * SAMPLE_RATE)
"""Kept at least: a word may have begun before what was taken for the beginning."""

QUIET_AFTER = MAX_PAUSE_SAMPLES + SEGMENT_MARGIN + 2 * FRAME
"""After a segment, until what began within the pause has made a frame stand out."""

QUIET_AFTER_ONSET = MAX_PAUSE_SAMPLES + ONSET_SAMPLES
"""After a segment, until what began within the pause is a segment."""

WARM_UP_FRAMES = 300
"""Frames from which all that is remembered of a stream follows: the background is of 266."""

VoiceFlags: TypeAlias = Callable[[bytes], bool]
"""Tells of one frame after the other whether there may be a voice in it."""


def webrtc_detector() -> VoiceFlags:
    """WebRTC's detector for one stream; it remembers all that it has heard of it."""
    found: VoiceFlags = Vad(VAD_MODE, SAMPLE_RATE, FRAME / SAMPLE_RATE).is_speech
    return found


class Segmenter:
    """Cuts one stream of samples, fed block by block, into stretches of speech."""

    def __init__(
        self,
        early: float | None = None,
        longest: float = MAX_SEGMENT_SECONDS,
        voices: VoiceFlags | None = None,
    ) -> None:
        """Start with nothing heard.

        Args:
            early: a segment that has paused for so long is yielded before it is over, s, and
                meanwhile what there is of it; None yields whole ones only.
            longest: what goes on for longer is looked through for what stands out within it, s.
            voices: tells in which frames a voice may be; None finds out.
        """
        self._longest = int(longest * SAMPLE_RATE)
        self._is_voice = voices or webrtc_detector()
        self._loudness = LevelMeter()
        self._background = Background()
        self._pause = None if early is None else max(1, round(early * SAMPLE_RATE / FRAME))
        self._stood: deque[bool] = deque(maxlen=ONSET_FRAMES)  # which frames stood out at all
        self._standing = 0  # frames that stood out, up to now
        self._kept: Samples = np.empty(0, np.int16)  # what a segment may still need
        self._kept_from = 0  # where that begins in the stream, in samples
        self._heard = 0  # samples that the VAD has seen
        self._open: OpenSegment | None = None  # the segment that goes on
        self._command_until = 0  # up to here all was for the robot
        self._last_end = 0
        self._quiet_reported = True  # about the silence after the last segment

    def feed(self, block: Samples) -> Iterator[Sound]:
        """Take the next samples of the stream.

        Args:
            block: any number of samples, 16 kHz.

        Yields:
            The segments whose end is known by now, and once after each that it stayed quiet.
        """
        self._kept = np.concatenate([self._kept, block])
        for frame, level in self._frames(self._unheard()):
            self._heard += FRAME
            yield from self._progress(frame, level)
        self._forget()

    def warm_up(self, at: int, before: Samples) -> None:
        """Begin in the midst of a stream where nothing is said, as if all before had been heard.

        Args:
            at: how much of the stream was before, in samples, a multiple of a frame.
            before: the last `WARM_UP_FRAMES` frames of that.
        """
        for frame, level in self._frames(before):
            voice = self._is_voice(frame)
            self._note(voice, level, self._background.follow(level, voice))
        self._kept, self._kept_from, self._heard = before, at - len(before), at
        self._forget()

    def resting_state(self) -> bytes | None:
        """Tell all that what follows hangs on; None if that is a segment under way or just over."""
        since = self._heard - max(self._last_end, self._command_until)
        if self._open or not self._quiet_reported or since < TALK_WINDOW:
            return None
        stood = bytes([*self._stood, self._standing])
        followed = self._loudness.state() + self._background.state()
        return stood + followed + self._kept[-MIN_KEPT_SAMPLES:].tobytes()

    def finish(self) -> Iterator[Sound]:
        """End the stream; yields the segment under way, if any, and that nothing follows."""
        self._heard += len(self._unheard())
        if self._open:
            yield self._over(self._open)
        yield from self._quiet()

    def cut(self) -> None:
        """Take the segment that has paused for over; what follows is another."""
        if self._open:
            self._end(self._open.paused_at(self._heard))
            self._standing = 0

    @property
    def background(self) -> float:
        """The level of the room, dB over one unit of the 16 bits."""
        return self._background.level

    def mark_command(self) -> None:
        """Learn that what was heard so far was for the robot, and no talk of others."""
        self._command_until = self._heard

    def _unheard(self) -> Samples:
        return self._kept[self._heard - self._kept_from :]

    def _frames(self, sound: Samples) -> Iterator[tuple[bytes, BandLevels]]:
        """The next frames of the stream, as the VAD takes them, and how loud they are."""
        whole = sound[: len(sound) // FRAME * FRAME]
        frames = (frame.tobytes() for frame in whole.reshape(-1, FRAME))
        return zip(frames, self._loudness.measure(whole), strict=True)

    def _progress(self, frame: bytes, level: BandLevels) -> Iterator[Sound]:
        """Follow the stream by a frame."""
        voice = self._is_voice(frame)
        background = self._background.follow(level, voice)
        if self._open is None:
            yield from self._begin(voice, level, background)
        else:
            yield from self._go_on(self._open, voice, level[0])
            if self._pause and self._open and self._heard // FRAME % ONGOING_INTERVAL == 0:
                so_far = self._kept[: self._heard - self._kept_from]
                yield Ongoing(self._heard / SAMPLE_RATE, so_far)

    def _begin(self, voice: bool, level: BandLevels, background: BandLevels) -> Iterator[Sound]:
        self._note(voice, level, background)
        if self._standing >= BEGIN_FRAMES:
            self._start_above(background, len(self._stood) - self._stood.index(True))
            return
        since = self._heard - self._last_end
        if since > QUIET_AFTER_ONSET or (since > QUIET_AFTER and not self._standing):
            yield from self._quiet()

    def _note(self, voice: bool, level: BandLevels, background: BandLevels) -> None:
        """Note whether a frame stood out, in either band and altogether."""
        low, high = (lv > room + BEGIN_ABOVE for lv, room in zip(level, background, strict=True))
        self._stood.append(low or high)
        self._standing = self._standing + 1 if voice and low else 0

    def _start_above(self, background: BandLevels, frames: int) -> None:
        """Begin a segment so many frames ago."""
        begin = self._heard - frames * FRAME - SEGMENT_MARGIN
        since = min(TALK_WINDOW, self._heard - self._command_until) // FRAME
        self._open = OpenSegment(
            start=max(self._last_end, begin),
            least=background[0] + CONTINUE_ABOVE,
            voices=self._background.voices,
            before=self._background.loudest(since, frames),
            levels=[background[0]] * frames,
            loud=BEGIN_FRAMES,
        )
        self._standing = 0
        self._stood.clear()

    def _go_on(self, now: OpenSegment, voice: bool, level: float) -> Iterator[Sound]:
        now.follow(voice, level)
        if (noise := self._noise_under(now)) is not None:
            yield self._over(now, self._heard - RISE_FRAMES * FRAME)
            self._background.settle(noise.usual)
            self._start_above(noise.highest, RISE_FRAMES)
        elif now.ended and now.is_click:
            self._open = None
        elif now.ended:
            yield self._over(now)
        elif self._heard - now.start > self._longest:
            yield from self._divided(now)
        elif now.silent == self._pause and not now.is_click:
            yield self._segment(now, now.paused_at(self._heard))._replace(over=False)

    def _divided(self, whole: OpenSegment) -> Iterator[Segment]:
        """Look for utterances in what goes on for longer than any; the last one may go on."""
        self._open = None
        for part in whole.divided(self._heard):
            part.start = max(self._last_end, part.start)
            self._open = part
            if part.ended:
                yield self._over(part)
        if self._open is None:
            self._end(self._heard)

    def _noise_under(self, now: OpenSegment) -> SteadyNoise | None:
        """The levels of a noise that began the segment, if something rises out of it now."""
        if self._heard - now.start < (STEADY_FRAMES + RISE_FRAMES) * FRAME + SEGMENT_MARGIN:
            return None
        steady = self._background.risen_above(BEGIN_ABOVE, MAX_STEADY_RANGE)
        if steady is not None:
            return steady
        noise = self._background.risen_above(BEGIN_ABOVE, MAX_NOISE_RANGE)
        return None if noise is None or self._voice_before() > MAX_NOISE_PROBABILITY else noise

    def _voice_before(self) -> float:
        """How sure it is that the segment is speech before what rises out of it now."""
        end = self._heard - RISE_FRAMES * FRAME - self._kept_from
        return shared_voice_detector().probability(
            self._kept[end - STEADY_FRAMES * FRAME - RUN_UP : end]
        )

    def _quiet(self) -> Iterator[Quiet]:
        if not self._quiet_reported:
            self._quiet_reported = True
            yield Quiet(self._heard / SAMPLE_RATE)

    def _over(self, now: OpenSegment, end: int | None = None) -> Segment:
        """End the segment under way, where it paused if not elsewhere."""
        end = now.paused_at(self._heard) if end is None else end
        segment = self._segment(now, end)
        self._end(end)
        return segment

    def _end(self, at: int) -> None:
        self._last_end = at
        self._open = None
        self._quiet_reported = False

    def _segment(self, now: OpenSegment, end: int) -> Segment:
        return now.segment(end, self._heard, self._kept, self._kept_from)

    def _forget(self) -> None:
        needed = (
            self._open.start - CONTEXT_SAMPLES if self._open else self._heard - MIN_KEPT_SAMPLES
        )
        surplus = min(needed, self._heard - MIN_KEPT_SAMPLES) - self._kept_from
        if surplus > 0:
            self._kept = self._kept[surplus:]
            self._kept_from += surplus


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
    return feed_all(Segmenter(), blocks)
