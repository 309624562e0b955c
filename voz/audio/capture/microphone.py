"""A microphone, through PortAudio: blocks of 16 kHz mono samples as they are heard."""

from __future__ import annotations

import queue
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
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
"""What the sound card hands over at a time."""

MAX_QUEUED_BLOCKS = 170
"""Blocks, 5 s, that wait for who is slow to take them; then the oldest are lost."""

BLOCK_TIMEOUT = 1.0
"""A device that gives nothing for so long is gone, s: even silence arrives as samples."""


class _Settings(NamedTuple):
    """How a device is opened: its number, Hz, and how many channels."""

    device: int
    rate: int
    channels: int


class _Arrived(NamedTuple):
    """A block, 32-bit floats of all channels, and when it arrived on the monotonic clock, s."""

    sound: bytes
    when: float


class Microphone:
    """An open microphone: iterate over it for its blocks, 16 kHz, int16, without an end.

    If they are not taken, the oldest are lost. When it fails, AudioError is raised.

    Attributes:
        name: of the device.
        alive: when it last handed something over, on the monotonic clock, s.
        arrived: when the block arrived that was last taken, on the monotonic clock, s.
        blocks_lost: how many blocks were lost, of `MICROPHONE_BLOCK_SECONDS` each.
        whole: whether all of the stream was heard when it ends, which it does not.
    """

    whole = True

    def __init__(self, name: str, rate: int, channels: int) -> None:
        self.name = name
        self.alive = self.arrived = time.monotonic()
        self.blocks_lost = 0
        self._channels = channels
        self._waiting: queue.Queue[_Arrived | None] = queue.Queue(MAX_QUEUED_BLOCKS)
        self._resampler = Resampler(rate)

    def heard(self, block: Any, _frames: int, _time: Any, status: Any) -> None:
        """Take what PortAudio hands over; called on its thread."""
        self.alive = time.monotonic()
        self.blocks_lost += bool(status.input_overflow)
        self._put(_Arrived(bytes(block), self.alive))  # PortAudio uses its block again

    def ended(self) -> None:
        """Let the reader know that nothing will follow; called on PortAudio's thread."""
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
    """Open a microphone for the length of a `with` block.

    Args:
        device: its number or a part of its name; None is the default one.

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
        raise AudioError(f"the microphone fails ({reason}); check the sound settings") from error


def _settings(sounddevice: ModuleType, device: Device) -> _Settings:
    """Find a way to open the device that it takes: best what the decoder needs."""
    for rate, channels in ((SAMPLE_RATE, 1), (device.rate, 1)):
        settings = _Settings(device.number, rate, channels)
        try:
            sounddevice.check_input_settings(settings.device, channels, "float32", samplerate=rate)
        except sounddevice.PortAudioError:
            continue
        return settings
    return _Settings(device.number, device.rate, device.channels)
