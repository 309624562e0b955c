"""Half duplex: while the robot itself can be heard, only commands that must not be missed are."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Protocol

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.echo import ECHO_EDGE, MAX_ECHO_DELAY, cancel_echo
from voz.events import Partial, Utterance, shift_time
from voz.recognition.recognizer import MICROPHONE, Recognizer
from voz.recognition.stream import Stream

REVERBERATION_SECONDS = 0.2
"""How long a room goes on giving back what was said, s."""

ECHO_FIT_SAMPLES = 2 * SAMPLE_RATE
"""What the echo is estimated from."""

CLEANED_SAMPLES = int(0.24 * SAMPLE_RATE)
"""How much is cleaned at a time: each time costs 30 ms of CPU."""


class Playback(Protocol):
    """What is known of the robot's own sound."""

    def busy_until(self) -> float:
        """When the last audible sample has left it, on the monotonic clock, s."""

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        """What it gave out last, 16 kHz, and when the last sample of it left, s."""


class HalfDuplex:
    """Stands between the microphone and the recognizer.

    What is heard while the loudspeaker sounds is cleaned of its echo and given to a stream of its
    own, of which only the commands count that must not be missed; the others are told as ignored.
    The usual stream hears silence.
    """

    def __init__(
        self,
        recognizer: Recognizer,
        loudspeaker: Playback | None,
        never_missed: Collection[str],
        source: str = MICROPHONE,
    ) -> None:
        """Start with nothing heard.

        Args:
            recognizer: what understands.
            loudspeaker: tells of the robot's own sound; None if the microphone cannot hear it.
            never_missed: the commands that are heard also while it sounds.
            source: what its utterances say that they come from.
        """
        self._recognizer = recognizer
        self._source = source
        self._loudspeaker = loudspeaker
        self._never_missed = never_missed
        self._usual = recognizer.stream(source)
        self._fed = 0  # samples of the stream
        self._window: Samples = np.zeros(ECHO_FIT_SAMPLES, np.int16)  # the last that were heard
        self._pending = 0  # of them that are not cleaned yet
        self._guard: Stream | None = None  # listens while the loudspeaker sounds
        self._guarded_since = 0.0  # in the stream, s

    @property
    def deaf(self) -> bool:
        """Whether the loudspeaker sounds, so that only what must not be missed counts."""
        return self._guard is not None

    @property
    def background(self) -> float:
        """The level of the room, dB over one unit of the 16 bits."""
        return self._usual.background

    def feed(self, block: Samples, arrived: float) -> Iterator[Utterance | Partial]:
        """Take what the microphone gave.

        Args:
            block: the next samples of the stream, 16 kHz.
            arrived: when they did, on the monotonic clock, s.

        Yields:
            What is heard, with the times of the stream.
        """
        if self._loudspeaker is None:
            yield from self._usual.feed(block)
            return
        self._fed += len(block)
        self._window = np.concatenate([self._window, block])[-ECHO_FIT_SAMPLES:]
        sounds = (
            arrived - len(block) / SAMPLE_RATE
            < self._loudspeaker.busy_until() + REVERBERATION_SECONDS
        )
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

    def _listen_over_playback(
        self, loudspeaker: Playback, samples: int, arrived: float
    ) -> Iterator[Utterance | Partial]:
        if self._guard is None:
            self._guard = self._recognizer.stream(self._source)
            self._pending = 0
            self._guarded_since = (self._fed - samples - ECHO_EDGE) / SAMPLE_RATE
        self._pending += samples
        if self._pending >= CLEANED_SAMPLES:
            cleaned = cancel_echo(self._window, self._played(loudspeaker, arrived))
            end = ECHO_FIT_SAMPLES - ECHO_EDGE
            yield from self._filter_events(self._guard.feed(cleaned[end - self._pending : end]))
            self._pending = 0

    def _played(self, loudspeaker: Playback, until: float) -> npt.NDArray[np.float32]:
        """What was given out, to the same moment as the window and from before it."""
        length = ECHO_FIT_SAMPLES + MAX_ECHO_DELAY
        played, end = loudspeaker.recent((length + SAMPLE_RATE // 2) / SAMPLE_RATE)
        beyond = round((end - until) * SAMPLE_RATE)
        played = played[: len(played) - beyond] if beyond > 0 else np.pad(played, (0, -beyond))
        return played[-length:]

    def _filter_events(
        self, events: Iterator[Utterance | Partial]
    ) -> Iterator[Utterance | Partial]:
        """What counts, and the commands that do not, marked so; the rest may be the robot's own."""
        for event in events:
            counts = event.text in self._never_missed or event.name in self._never_missed
            if isinstance(event, Utterance) and event.accepted:
                event = event if counts else replace(event, ignored="robot_speaking")
                yield shift_time(event, self._guarded_since)
            elif isinstance(event, Partial) and counts:
                yield shift_time(event, self._guarded_since)
