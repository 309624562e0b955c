"""A microphone, through PortAudio: blocks of 16 kHz mono samples as they are heard."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.files import to_int16
from voz.audio.portaudio import load_sounddevice, running
from voz.errors import AudioError

Block: TypeAlias = npt.NDArray[np.float32]

BLOCK_SECONDS = 0.02
"""What the sound card hands over at a time."""

MOST_WAITING = 250
"""Blocks, 5 s, that wait for who is slow to take them; then the oldest are lost."""

SILENT_FOR = 3.0
"""A device that gives nothing for so long is gone, s: even silence arrives as samples."""


class _Settings(NamedTuple):
    """How a device is opened: its number, Hz, and how many channels."""

    device: int
    rate: int
    channels: int


@contextmanager
def listening(device: str | None = None) -> Iterator[Iterator[Samples]]:
    """Open a microphone for the length of a `with` block.

    Args:
        device: its number or a part of its name; None is the default one.

    Yields:
        Its blocks, 16 kHz, int16, without an end. If they are not taken, the oldest are lost.

    Raises:
        AudioError: there is no such microphone, or it fails, then or later.
    """
    sounddevice = load_sounddevice()
    settings = _settings(sounddevice, device)
    waiting: queue.Queue[Block | None] = queue.Queue(MOST_WAITING)

    def put(block: Block | None) -> None:
        if waiting.full():
            with suppress(queue.Empty):  # just then the last one was taken
                waiting.get_nowait()
        waiting.put_nowait(block)

    def heard(block: Block, *_: Any) -> None:
        put(block.copy())  # PortAudio uses its block again

    try:
        with running(
            "InputStream",
            samplerate=settings.rate,
            blocksize=round(BLOCK_SECONDS * settings.rate),
            device=settings.device,
            channels=settings.channels,
            dtype="float32",
            callback=heard,
            finished_callback=lambda: put(None),
        ):
            yield _blocks(waiting, settings.rate)
    except sounddevice.PortAudioError as error:
        reason = " ".join(str(error).split())
        raise AudioError(f"the microphone fails ({reason}); check the sound settings") from error


def _settings(sounddevice: ModuleType, device: str | None) -> _Settings:
    """Find the device, and a way to open it that it takes: best what the decoder needs."""
    wanted = int(device) if device is not None and device.isdecimal() else device
    try:
        found = sounddevice.query_devices(wanted, "input")
    except (sounddevice.PortAudioError, ValueError) as error:
        raise AudioError(_no_microphone(sounddevice, device)) from error
    own_rate = int(found["default_samplerate"])
    for rate, channels in ((SAMPLE_RATE, 1), (own_rate, 1)):
        settings = _Settings(found["index"], rate, channels)
        try:
            sounddevice.check_input_settings(settings.device, channels, "float32", samplerate=rate)
        except sounddevice.PortAudioError:
            continue
        return settings
    return _Settings(found["index"], own_rate, found["max_input_channels"])


def _no_microphone(sounddevice: ModuleType, device: str | None) -> str:
    inputs = [d for d in sounddevice.query_devices() if d["max_input_channels"] > 0]
    if not inputs or device is None:
        return "there is no microphone; connect one and start again"
    names = ", ".join(f'{d["index"]} "{d["name"]}"' for d in inputs)
    return f'there is not exactly one microphone "{device}"; take the number of one of: {names}'


def _blocks(waiting: queue.Queue[Block | None], rate: int) -> Iterator[Samples]:
    import soxr  # 20 ms that who opens no microphone need not wait for

    resampler = soxr.ResampleStream(rate, SAMPLE_RATE, 1, dtype="float32")
    while True:
        try:
            block = waiting.get(timeout=SILENT_FOR)
        except queue.Empty:
            block = None
        if block is None:
            raise AudioError("the microphone is gone; connect it and start again")
        sound = block.mean(axis=1)
        yield to_int16(sound if rate == SAMPLE_RATE else resampler.resample_chunk(sound))
