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
from voz.audio.playback import PLAYBACK_RATE, Wave
from voz.errors import AudioError

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
