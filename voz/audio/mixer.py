"""Plays several sounds at once."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from voz.audio.loudspeaker import PLAYBACK_LATENCY, Loudspeaker
from voz.audio.playback import PLAYBACK_RATE, PlaybackHistory, PlayingSound, Wave, mix, to_16_khz

MAX_START_DELAY = 2.0
"""A sound that cannot start within this time is dropped, s: it would come too late."""

LATE_CHECK_INTERVAL = 0.1
"""Between checks of whether a sound is late, s."""

FADE_TIMEOUT = 0.2
"""Longest time that `close` waits for fading sounds, s."""


class Mixer:
    """Plays sounds on the default output device, which is open only while there are any.

    Without a loudspeaker sounds are dropped, but repeating ones are heard when it is back.

    Args:
        warn: called with a message, from another thread, when the loudspeaker is lost.

    Attributes:
        barge_in: whether commands count while it speaks; see `replies`.
    """

    def __init__(self, warn: Callable[[str], None]) -> None:
        self.barge_in = False
        self._warn = warn
        self._changed = threading.Condition()  # guards what follows
        self._sources: dict[PlayingSound, float] = {}  # with when they were to begin
        self._history = PlaybackHistory()
        self._gain = 1.0
        self._closed = False
        self._loudspeaker = Loudspeaker(self._fill, self._needed, self._leave_out)

    def prepare(self) -> None:
        """Import PortAudio in the background, so that the first sound need not wait."""
        self._loudspeaker.wake()

    def play(
        self, sound: Wave, volume: float = 1.0, repeats: bool = False, text: str | None = None
    ) -> PlayingSound:
        """Start a sound beside those that are playing; arguments as of `PlayingSound`."""
        source = PlayingSound(sound, volume, repeats, text)
        with self._changed:
            if self._closed:
                source.drop()
            self._sources[source] = time.monotonic()
            self._clear()
        self._loudspeaker.wake()
        return source

    def stop(self, source: PlayingSound) -> None:
        """Fade a sound out, within 30 ms."""
        with self._changed:
            source.stop()
            self._clear()

    def wait(self, source: PlayingSound) -> None:
        """Wait until a sound has ended, was stopped, or was dropped without a loudspeaker."""
        with self._changed:
            while not source.over:
                self._changed.wait(LATE_CHECK_INTERVAL)
                self._clear()

    def busy_until(self) -> float:
        """Return when the last audible sample is heard, monotonic s; infinite if one repeats."""
        with self._changed:
            left = max((source.audible_left for source in self._sources), default=0)
            if not left or self._loudspeaker.is_lost:
                return self._history.audible_until
            now = time.monotonic()
            handed = self._history.end if self._loudspeaker.is_open else now + PLAYBACK_LATENCY
            return max(now, handed) + left / PLAYBACK_RATE

    def replies(self) -> str | None:
        """Return what is said, if `barge_in` is on and no other sound plays; else None."""
        with self._changed:
            texts = [source.text for source in self._sources]
        known = [text for text in texts if text is not None]
        return " ".join(known) if self.barge_in and len(known) == len(texts) else None

    def recent(self, seconds: float) -> tuple[Wave, float]:
        """Return the sound of the last seconds, 16 kHz, and when its last sample is heard, s.

        Silence is included; at most 5.9 s.
        """
        with self._changed:
            cut, end = self._history.last(seconds, time.monotonic())
        return to_16_khz(cut), end

    def close(self) -> None:
        """Fade all sounds out, and play nothing more."""
        with self._changed:
            self._closed = True
            for source in self._sources:
                source.stop()
            self._clear()
            deadline = time.monotonic() + FADE_TIMEOUT
            while self._sources and (left := deadline - time.monotonic()) > 0:
                self._changed.wait(left)
            heard = min(self._history.audible_until, deadline)
        time.sleep(max(0.0, heard - time.monotonic()))
        self._loudspeaker.close()

    # Called by the loudspeaker's threads

    def _fill(self, frames: int, time: float) -> Wave:
        with self._changed:
            self._clear()
            block, self._gain = mix(list(self._sources), frames, self._gain)
            self._history.add(block, time)
            self._clear()
        return block

    def _needed(self) -> bool:
        with self._changed:
            self._clear()
            return bool(self._sources)

    def _leave_out(self, problem: str | None) -> None:
        with self._changed:
            for source in self._sources:
                if not source.repeats:
                    source.drop()
            self._clear()
        if problem:
            self._warn(problem)

    def _clear(self) -> None:
        latest = time.monotonic() - MAX_START_DELAY
        for source, begin in self._sources.items():
            if not (source.begun or source.repeats or begin > latest):
                source.drop()
        if any(source.over for source in self._sources):
            self._sources = {s: begin for s, begin in self._sources.items() if not s.over}
            self._changed.notify_all()
