"""Half duplex: while the robot's own sound is heard, only the `never_missed` commands count."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from typing import Protocol

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.echo import ECHO_EDGE, MAX_ECHO_DELAY, cancel_echo
from voz.events import Partial, Utterance, shift_time
from voz.language.sentences.spelling import normalize
from voz.recognition.recognizer import MICROPHONE, Recognizer, open_stream
from voz.recognition.stream import Stream

REVERBERATION_SECONDS = 0.2
"""How long a room reverberates."""

ECHO_FIT_SAMPLES = 2 * SAMPLE_RATE
"""The echo is estimated from these."""

MAX_REPLY_DELAY = int(1.1 * SAMPLE_RATE)
"""The same of a page, which begins to play within a second: see `MAX_ECHO_DELAY`."""

MAX_ANSWER_SECONDS = 3.0
"""What is being said when a reply is over is heard to its end, but no longer than this."""

CLEANED_SAMPLES = int(0.24 * SAMPLE_RATE)
"""Cleaned at a time, which costs 30 ms of CPU."""


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
        recognizer: Recognizer,
        loudspeaker: Playback | None,
        never_missed: Collection[str],
        source: str = MICROPHONE,
    ) -> None:
        """Start a stream.

        Args:
            recognizer: makes the streams.
            loudspeaker: the robot's own sound; None if the microphone cannot hear it.
            never_missed: the commands that count during playback.
            source: the `source` of the utterances.
        """
        self._recognizer = recognizer
        self._source = source
        self._loudspeaker = loudspeaker
        self._never_missed = never_missed
        self._usual = open_stream(recognizer, source)
        self._fed = 0  # samples of the stream
        self._window: Samples = np.zeros(ECHO_FIT_SAMPLES, np.int16)  # the last that were heard
        self._pending = 0  # of them that are not cleaned yet
        self._guard: Stream | None = None  # listens while the loudspeaker sounds
        self._guarded_since = 0.0  # in the stream, s
        self._reply_words: set[str] | None = None  # of all that was played since; None: not known

    @property
    def deaf(self) -> bool:
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
        yield from self._usual.feed(block)

    def finish(self) -> Iterator[Utterance | Partial]:
        """End the stream; yields what was still open."""
        if self._guard:
            yield from self._filter_events(self._guard.finish())
            self._guard = None
        yield from self._usual.finish()

    def _sounds(self, loudspeaker: Playback, when: float) -> bool:
        """Whether a block that began at a time is heard as one during playback."""
        since = when - loudspeaker.busy_until() - REVERBERATION_SECONDS
        if since < 0 or self._guard is None or self._reply_words is None:
            return since < 0
        return self._guard.amid_speech and since < MAX_ANSWER_SECONDS

    def _listen_over_playback(
        self, loudspeaker: Playback, samples: int, arrived: float
    ) -> Iterator[Utterance | Partial]:
        if self._guard is None:
            self._guard = open_stream(self._recognizer, self._source)
            self._pending = 0
            self._reply_words = set()
            self._guarded_since = (self._fed - samples - ECHO_EDGE) / SAMPLE_RATE
        replies = loudspeaker.replies()
        if replies is None or self._reply_words is None:
            self._reply_words = None
        else:
            self._reply_words.update(_words(replies))
        self._pending += samples
        if self._pending >= CLEANED_SAMPLES:
            cleaned = cancel_echo(self._window, self._played(loudspeaker, arrived))
            end = ECHO_FIT_SAMPLES - ECHO_EDGE
            yield from self._filter_events(self._guard.feed(cleaned[end - self._pending : end]))
            self._pending = 0

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
            counts = (
                event.text in self._never_missed
                or event.name in self._never_missed
                or (self._reply_words is not None and not self._reply_words & _words(event.text))
            )
            if isinstance(event, Utterance) and event.accepted:
                event = event if counts else replace(event, ignored="robot_speaking")
                yield shift_time(event, self._guarded_since)
            elif isinstance(event, Partial) and counts:
                yield shift_time(event, self._guarded_since)


def _words(text: str) -> set[str]:
    return set(re.findall(r"\w+", normalize(text)))
