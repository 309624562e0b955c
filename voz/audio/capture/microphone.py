"""A microphone, through PortAudio: blocks of 16 kHz mono samples as they arrive."""

from __future__ import annotations

import queue
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.capture.input_devices import Device, choose_microphone
from voz.audio.capture.pulse import pulse_source_selected
from voz.audio.capture.resampling import Resampler
from voz.audio.portaudio import load_sounddevice, open_stream
from voz.errors import AudioError

MICROPHONE_BLOCK_SECONDS = 0.03
"""Length of a block of the sound card."""

MAX_QUEUED_BLOCKS = 170
"""5 s of blocks that wait to be taken; then the oldest are dropped."""

BLOCK_TIMEOUT = 1.0
"""A device that gives no block for this time is lost, s; even silence arrives as samples."""


@dataclass(frozen=True)
class _Settings:
    device: int
    rate: int
    channels: int


class _Arrived(NamedTuple):
    """A block, 32-bit floats of all channels, and its monotonic arrival time, s."""

    sound: bytes
    when: float


class Microphone:
    """An open microphone: an iterator over its blocks, 16 kHz, without an end.

    Blocks that are not taken are dropped, the oldest first. When it fails, AudioError is raised.

    Attributes:
        name: of the device.
        alive: monotonic time of the last callback, s.
        arrived: monotonic arrival time of the block that was taken last, s.
        blocks_lost: number of dropped blocks, of `MICROPHONE_BLOCK_SECONDS` each.
        whole, addressed: see `OpenMicrophone`.
    """

    whole = True
    addressed = False

    def __init__(self, name: str, rate: int, channels: int) -> None:
        self.name = name
        self.alive = self.arrived = time.monotonic()
        self.blocks_lost = 0
        self._channels = channels
        self._waiting: queue.Queue[_Arrived | None] = queue.Queue(MAX_QUEUED_BLOCKS)
        self._resampler = Resampler(rate)

    def heard(self, block: Any, _frames: int, _time: Any, status: Any) -> None:
        """PortAudio's callback."""
        self.alive = time.monotonic()
        self.blocks_lost += bool(status.input_overflow)
        self._put(_Arrived(bytes(block), self.alive))  # PortAudio uses its block again

    def ended(self) -> None:
        """PortAudio's callback at the end of the stream."""
        self._put(None)

    def __iter__(self) -> Iterator[Samples]:
        return self

    def __next__(self) -> Samples:
        try:
            arrived = self._waiting.get(timeout=BLOCK_TIMEOUT)
        except queue.Empty:
            arrived = None
        if arrived is None:
            raise AudioError("the microphone is gone; connect it and start again")
        self.arrived = arrived.when
        channels = np.frombuffer(arrived.sound, np.float32).reshape(-1, self._channels)
        return self._resampler.feed(channels.mean(axis=1))

    def _put(self, arrived: _Arrived | None) -> None:
        if self._waiting.full():
            self.blocks_lost += 1
            with suppress(queue.Empty):  # just then the last one was taken
                self._waiting.get_nowait()
        self._waiting.put_nowait(arrived)


@contextmanager
def open_microphone(device: str | None = None) -> Iterator[Microphone]:
    """Open a microphone for a `with` block: a number, or a part of a name; None is the default.

    Raises:
        AudioError: there is no such microphone, or it fails.
    """
    sounddevice = load_sounddevice()
    chosen = choose_microphone(device)
    settings = _settings(sounddevice, chosen)
    microphone = Microphone(chosen.name, settings.rate, settings.channels)
    try:
        with (
            pulse_source_selected(chosen.name if chosen.is_source else None),
            open_stream(
                "RawInputStream",
                samplerate=settings.rate,
                blocksize=round(MICROPHONE_BLOCK_SECONDS * settings.rate),
                device=settings.device,
                channels=settings.channels,
                dtype="float32",
                latency="low",
                callback=microphone.heard,
                finished_callback=microphone.ended,
            ),
        ):
            yield microphone
    except sounddevice.PortAudioError as error:
        reason = " ".join(str(error).split())
        raise AudioError(f"the microphone fails ({reason})", "check the sound settings") from error


def _settings(sounddevice: ModuleType, device: Device) -> _Settings:
    """Return the first settings that the device accepts, 16 kHz mono if possible."""
    for rate, channels in ((SAMPLE_RATE, 1), (device.rate, 1)):
        settings = _Settings(device.number, rate, channels)
        try:
            sounddevice.check_input_settings(settings.device, channels, "float32", samplerate=rate)
        except sounddevice.PortAudioError:
            continue
        return settings
    return _Settings(device.number, device.rate, device.channels)
