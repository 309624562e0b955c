"""Half duplex: while the robot's own sound is heard, only the `never_missed` commands count."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator
from typing import Protocol

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.echo import ECHO_EDGE, NOTHING_CLEANED, Cleaned, EchoCanceller
from voz.audio.echo_alignment import MAX_ECHO_DELAY
from voz.audio.segment import feed_all
from voz.audio.sound_files import to_int16
from voz.events import Partial, Utterance, shift_time
from voz.language.sentences.spelling import normalize
from voz.recognition.engine import MICROPHONE, RecognitionEngine, open_playback_spotter, open_stream
from voz.recognition.spotting import PLAYBACK_WINDOW
from voz.recognition.stream import Stream
from voz.recognition.thresholds import COMMAND_LIMITS, STOP_LIMITS, PlaybackLimits

REVERBERATION_SECONDS = 0.2
"""How long a room reverberates."""

ECHO_FIT_SAMPLES = 2 * SAMPLE_RATE
"""The echo is estimated from these."""

MAX_REPLY_DELAY = int(1.1 * SAMPLE_RATE)
"""Longest delay of a reply played by a page, samples; see `MAX_ECHO_DELAY`."""

MAX_ANSWER_SECONDS = 3.0
"""What is being said when a reply is over is heard to its end, but no longer than this."""

MAX_RECOGNIZED_DELAY = 2.0
"""A reply may be heard as a command this long after it was played, s."""

MAX_LATE_PLAYBACK = 3.0
"""A loudspeaker may be so much later than its device says, s: wireless ones, televisions and
loudspeakers in the network were up to 2 s late."""

MAX_RECENT_SECONDS = 5.9
"""This much of what was played is remembered, s."""

MAX_RECORD_SAMPLES = 10 * SAMPLE_RATE
"""Cleaned sound that is kept, to check what seems to be a command once more."""

CLEANED_SAMPLES = int(0.24 * SAMPLE_RATE)
"""Samples cleaned at a time, which costs 44 ms of CPU (`benchmarks/echo.py --softer`)."""

CLEANED_END = ECHO_FIT_SAMPLES - ECHO_EDGE
"""Up to here the samples of a window are complete."""


class Playback(Protocol):
    """The robot's own sound."""

    def busy_until(self) -> float:
        """Monotonic time when the last audible sample is heard, s."""

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        """What was played last, 16 kHz, and when the last sample is heard, s."""

    def replies(self) -> str | None:
        """The words of what sounds, if all commands count that have no word in common with them.

        None if more may sound than `recent` has.
        """


class HalfDuplex:
    """Stands between the microphone and the recognizer.

    During playback the sound is cleaned of its echo and fed to a second stream, of which only the
    `never_missed` commands count; other commands are marked as ignored. If all that is played is
    known to be a reply, every command counts that has no word in common with that: an echo that was
    not removed cannot be taken for it. The main stream gets silence.
    """

    def __init__(
        self,
        recognizer: RecognitionEngine,
        loudspeaker: Playback | None,
        never_missed: Collection[str],
        source: str = MICROPHONE,
    ) -> None:
        """Start a stream; `never_missed` are the commands that count during playback.

        The loudspeaker is the robot's own; None if the microphone cannot hear it.
        """
        self._recognizer = recognizer
        self._source = source
        self._loudspeaker = loudspeaker
        self._never_missed = never_missed
        self._usual = open_stream(recognizer, source)
        self._fed = 0  # samples of the stream
        self._arrived = 0.0  # when the last of them did, monotonic s
        self._canceller = EchoCanceller()
        self._spotter = open_playback_spotter(recognizer, source)
        self._stopped_until = -math.inf  # when the last that is never missed ended, s
        self._window: Samples = np.zeros(ECHO_FIT_SAMPLES, np.int16)  # the last that were heard
        self._pending = 0  # of them that are not cleaned yet
        self._guard: Stream | None = None  # listens while the loudspeaker sounds
        self._guard_fed = 0  # samples
        self._record = NOTHING_CLEANED  # the last of what it was fed
        self._guarded_since = 0.0  # in the stream, s
        self._reply_words: set[str] | None = None  # of all that was played since; None: not known

    @property
    def speaking(self) -> bool:
        """Whether there is playback during which only `never_missed` commands count."""
        return self._guard is not None and self._reply_words is None

    @property
    def background(self) -> float:
        """Level of the room, dB relative to one unit of the 16 bits."""
        return self._usual.background

    def feed(self, block: Samples, arrived: float) -> Iterator[Utterance | Partial]:
        """Take the next block of the microphone, 16 kHz; yield events in the time of the stream.

        The monotonic time when it arrived is `arrived`, s.
        """
        if self._loudspeaker is None:
            yield from self._usual.feed(block)
            return
        self._fed += len(block)
        self._window = np.concatenate([self._window, block])[-ECHO_FIT_SAMPLES:]
        sounds = self._sounds(self._loudspeaker, arrived - len(block) / SAMPLE_RATE)
        if sounds or self._guard:
            yield from self._listen_over_playback(self._loudspeaker, len(block), arrived)
            block = np.zeros_like(block)
        if not sounds and self._guard:
            yield from self._filter_events(self._guard.finish())
            self._guard = None
        self._arrived = arrived
        yield from map(self._marked, self._usual.feed(block))

    def finish(self) -> Iterator[Utterance | Partial]:
        """End the stream; yields what was still open."""
        if self._guard:
            yield from self._filter_events(self._guard.finish())
            self._guard = None
        yield from map(self._marked, self._usual.finish())

    def _sounds(self, loudspeaker: Playback, when: float) -> bool:
        """Whether a block that began at a time is heard as one during playback."""
        since = when - loudspeaker.busy_until() - REVERBERATION_SECONDS
        if since < 0 or self._guard is None or self._reply_words is None:
            return since < 0
        return self._guard.in_segment and since < MAX_ANSWER_SECONDS

    def _listen_over_playback(
        self, loudspeaker: Playback, samples: int, arrived: float
    ) -> Iterator[Utterance | Partial]:
        if self._guard is None:
            self._guard = open_stream(self._recognizer, self._source, spotting=False)
            self._spotter = open_playback_spotter(self._recognizer, self._source)
            self._pending = self._guard_fed = 0
            self._record = NOTHING_CLEANED
            self._reply_words = set()
            self._guarded_since = (self._fed - samples - ECHO_EDGE) / SAMPLE_RATE
        replies = loudspeaker.replies()
        if replies is None or self._reply_words is None:
            self._reply_words = None
        else:
            self._reply_words.update(_words(replies))
        self._pending += samples
        if self._pending >= CLEANED_SAMPLES:
            cleaned = self._canceller.clean(self._window, self._played(loudspeaker, arrived))
            new = cleaned.cut(slice(CLEANED_END - self._pending, CLEANED_END))
            self._record = self._record.followed_by(new, MAX_RECORD_SAMPLES)
            self._guard_fed += self._pending
            self._pending = 0
            yield from self._filter_events(self._guard.feed(new.samples))
            yield from self._check(cleaned)

    def _check(self, cleaned: Cleaned) -> Iterator[Utterance]:
        """Report a command that is never missed, if it is in this window and the ones before."""
        part = cleaned.cut(slice(CLEANED_END - PLAYBACK_WINDOW, CLEANED_END))
        said = self._spotter.check(part, (self._fed - ECHO_EDGE) / SAMPLE_RATE)
        if said and said.start > self._stopped_until:
            self._stopped_until = said.end
            yield said

    def _played(self, loudspeaker: Playback, until: float) -> npt.NDArray[np.float32]:
        """Return what was played during the window, and from the longest delay before it."""
        delay = MAX_ECHO_DELAY if self._reply_words is None else MAX_REPLY_DELAY
        length = ECHO_FIT_SAMPLES + delay
        played, end = loudspeaker.recent((length + SAMPLE_RATE // 2) / SAMPLE_RATE)
        beyond = round((end - until) * SAMPLE_RATE)
        played = played[: len(played) - beyond] if beyond > 0 else np.pad(played, (0, -beyond))
        return played[-length:]

    def _filter_events(
        self, events: Iterator[Utterance | Partial]
    ) -> Iterator[Utterance | Partial]:
        """Pass on commands that count, and mark others as ignored; drop the rest."""
        for event in events:
            never_missed = self._is_never_missed(event)
            if isinstance(event, Partial):
                if never_missed and not self._spotter.works:
                    yield shift_time(event, self._guarded_since)
            elif event.accepted and never_missed:
                start = event.start + self._guarded_since
                if start >= self._stopped_until and self._is_said(event, STOP_LIMITS):
                    self._stopped_until = event.end + self._guarded_since
                    yield shift_time(event, self._guarded_since)
            elif event.accepted:
                event = event if self._counts(event) else replace(event, ignored="robot_speaking")
                yield shift_time(event, self._guarded_since)

    def _counts(self, event: Utterance) -> bool:
        """Whether a command cannot be the robot's own words, by their text and by their sound."""
        if self._loudspeaker is None or self._reply_words is None:
            return False
        if self._reply_words & _words(event.text) or not self._is_said(event, COMMAND_LIMITS):
            return False
        since = self._fed / SAMPLE_RATE - self._guarded_since - event.start
        played, _ = self._loudspeaker.recent(since + MAX_RECOGNIZED_DELAY)
        return not self._spotter.may_be_echo(event.text, played)

    def _is_never_missed(self, event: Utterance | Partial) -> bool:
        return not {event.text, event.name}.isdisjoint(self._never_missed)

    def _marked(self, event: Utterance | Partial) -> Utterance | Partial:
        """Mark a command that may be what a late loudspeaker says; one that stops never is."""
        if self._loudspeaker is None or isinstance(event, Partial) or not event.accepted:
            return event
        since = self._fed / SAMPLE_RATE - event.start
        quiet = self._arrived - since - self._loudspeaker.busy_until()  # before it was said
        if quiet > MAX_LATE_PLAYBACK or self._is_never_missed(event):
            return event
        played, _ = self._loudspeaker.recent(min(since + MAX_LATE_PLAYBACK, MAX_RECENT_SECONDS))
        return replace(event, ignored="robot_speaking") if self._says(played, event.text) else event

    def _says(self, played: npt.NDArray[np.float32], text: str) -> bool:
        """Whether a command is heard in what was played, 16 kHz: without a room it is clear."""
        own = open_stream(self._recognizer, self._source, spotting=False)
        return any(heard.text == text for heard in feed_all(own, [to_int16(played)]))

    def _is_said(self, event: Utterance, limits: PlaybackLimits) -> bool:
        begin = (self._guard_fed - len(self._record.samples)) / SAMPLE_RATE
        start, end = event.start - begin, event.end - begin
        return self._spotter.is_said(event.text, self._record, start, end, limits)


def _words(text: str) -> set[str]:
    return set(re.findall(r"\w+", normalize(text)))
