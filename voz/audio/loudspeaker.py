"""The default output device, open while it is needed.

A thread opens and closes it, so that nobody waits for a sound server, and tries again when it is
lost.
"""

from __future__ import annotations

import atexit
import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import Any, TypeAlias

import numpy as np

from voz.audio import portaudio
from voz.audio.playback import PLAYBACK_RATE, PlaybackHistory, PlayingSound, Wave, mix, to_16_khz
from voz.errors import AudioError

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


Fill: TypeAlias = Callable[[int, float], Wave]

PLAYBACK_BLOCK_SECONDS = 0.01

PLAYBACK_LATENCY = 0.02
"""Buffer of the device, s; a stopped sound is heard for this time and a fade."""

MAX_IDLE_SECONDS = 2.0
"""Time that the device stays open without a sound."""

STALL_TIMEOUT = 1.0
"""A device that has taken no block for this time is lost, s."""

FIRST_RETRY, LAST_RETRY = 0.5, 5.0
"""Delay before a lost device is tried again, s, doubled each time."""

MIN_UPTIME = 2.0
"""A device that is lost sooner was never really back, s: no new warning."""

DEVICE_CHECK_INTERVAL = 0.1
"""Between checks of whether the device is needed and works, s."""

DEVICE_CLOSE_TIMEOUT = 1.0
"""Only a hanging sound server takes longer, s."""


class Loudspeaker:
    """Plays what `fill` returns. All three functions are called from other threads.

    Args:
        fill: returns a number of samples at `PLAYBACK_RATE`, the first of which is heard at a
            monotonic time; called 100 times a second while the device is open.
        needed: whether there is anything to play.
        on_trouble: called when the device is lost, with a message or, if it still is, None.
    """

    def __init__(
        self, fill: Fill, needed: Callable[[], bool], on_trouble: Callable[[str | None], None]
    ) -> None:
        self.is_open = False
        self._fill = fill
        self._needed = needed
        self._on_trouble = on_trouble
        self._starting = threading.Lock()
        self._wake = threading.Event()
        self._closing = threading.Event()
        self._stream_ended = False
        self._last_block = -math.inf
        self._failures = 0
        self._rate = 0  # Hz, not known yet
        self._thread = threading.Thread(target=self._work, name="voz-loudspeaker", daemon=True)

    @property
    def is_lost(self) -> bool:
        """Whether there was no device, or it failed, when it was last needed."""
        return self._failures > 0 and not self.is_open

    def wake(self) -> None:
        """Check now whether the device is needed; the first call starts the thread."""
        with self._starting:
            if not self._thread.is_alive() and not self._closing.is_set():
                self._thread.start()
        self._wake.set()

    def close(self) -> None:
        """Close the device for good."""
        self._closing.set()
        self._wake.set()
        atexit.unregister(self.close)
        if self._thread.is_alive():
            self._thread.join(DEVICE_CLOSE_TIMEOUT)
            if self._thread.is_alive():
                portaudio.abandon_streams()

    def _work(self) -> None:
        with suppress(AudioError):  # reported when there is something to play
            portaudio.load_sounddevice()
            # Registered after sounddevice's own exit handler, and so called before it: Python must
            # not end while PortAudio still asks for blocks.
            atexit.register(self.close)
        while not self._closing.is_set():
            self._wake.wait()
            self._wake.clear()
            while self._needed() and not self._closing.is_set():
                self._serve()
                if self._failures:
                    delay = min(FIRST_RETRY * 2 ** (self._failures - 1), LAST_RETRY)
                    self._closing.wait(delay)

    def _serve(self) -> None:
        try:
            with self._open():
                opened = time.monotonic()
                problem = self._attend()
                if not problem or time.monotonic() - opened > MIN_UPTIME:
                    self._failures = 0
                if problem:  # reported before closing, which may take long
                    self._fail(problem)
        except AudioError as error:
            self._fail(str(error))

    def _fail(self, problem: str) -> None:
        self._failures += 1
        self._on_trouble(problem if self._failures == 1 else None)

    def _attend(self) -> str | None:
        """Wait while the device is needed and works; return what is wrong."""
        last_needed = time.monotonic()
        while True:
            self._wake.wait(DEVICE_CHECK_INTERVAL)
            self._wake.clear()
            now = time.monotonic()
            if self._needed():
                last_needed = now
            if self._closing.is_set() or now - last_needed > MAX_IDLE_SECONDS:
                return None
            if self._stream_ended or now - self._last_block > STALL_TIMEOUT:
                return "the loudspeaker is gone; it is used again as soon as it is back"

    @contextmanager
    def _open(self) -> Iterator[None]:
        sounddevice = portaudio.load_sounddevice()
        if self._failures:
            portaudio.refresh_devices()
        if self._failures or not self._rate:
            self._rate = _usable_rate(sounddevice)
        rate = self._rate
        fill = self._fill if rate == PLAYBACK_RATE else _resampled(self._fill, rate)
        self._stream_ended = False
        self._last_block = time.monotonic()

        def give(block: Any, frames: int, times: Any, _: Any) -> None:
            self._last_block = time.monotonic()
            delay = max(0.0, times.outputBufferDacTime - times.currentTime)
            np.frombuffer(block, np.float32)[:] = fill(frames, self._last_block + delay)

        def end() -> None:
            self._stream_ended = True
            self._wake.set()

        try:
            with portaudio.open_stream(
                "RawOutputStream",
                samplerate=rate,
                blocksize=round(PLAYBACK_BLOCK_SECONDS * rate),
                channels=1,
                dtype="float32",
                latency=PLAYBACK_LATENCY,
                callback=give,
                finished_callback=end,
            ):
                self.is_open = True
                yield
        except portaudio.audio_errors(sounddevice) as error:
            reason = " ".join(str(error).split())
            raise AudioError(
                f"the loudspeaker fails ({reason})", "check the sound settings"
            ) from error
        finally:
            self.is_open = False


def _usable_rate(sounddevice: ModuleType) -> int:
    """Return a rate for the default device, Hz: ours, or its own if it takes no other."""
    try:
        device = sounddevice.query_devices(kind="output")
    except portaudio.audio_errors(sounddevice):
        portaudio.refresh_devices()
        try:
            device = sounddevice.query_devices(kind="output")
        except portaudio.audio_errors(sounddevice) as error:
            raise AudioError("there is no loudspeaker; connect one") from error
    try:
        sounddevice.check_output_settings(channels=1, dtype="float32", samplerate=PLAYBACK_RATE)
    except portaudio.audio_errors(sounddevice):
        return int(device["default_samplerate"])
    return PLAYBACK_RATE


def _resampled(fill: Fill, rate: int) -> Fill:
    import soxr

    resampler = soxr.ResampleStream(PLAYBACK_RATE, rate, 1, dtype="float32")
    ready: Wave = np.empty(0, np.float32)

    def give(frames: int, time: float) -> Wave:
        nonlocal ready
        while len(ready) < frames:
            block = fill(round(PLAYBACK_BLOCK_SECONDS * PLAYBACK_RATE), time + len(ready) / rate)
            ready = np.concatenate([ready, resampler.resample_chunk(block)])
        block, ready = ready[:frames], ready[frames:]
        return block

    return give
