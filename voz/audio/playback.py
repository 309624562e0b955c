"""Sound files to the loudspeaker, through PortAudio."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import numpy.typing as npt
import soundfile

from voz.errors import AudioError

BLOCK_SECONDS = 0.1
"""What is handed over at a time: Ctrl-C and `stopped` are heard in between."""

TAIL_SECONDS = 0.2
"""Silence at the end: PortAudio stops before what its buffer holds was heard, here 35 ms."""


def play(path: Path, stopped: threading.Event | None = None) -> None:
    """Play a sound file on the default output device and wait until it has been heard.

    Args:
        path: a file in any format, rate and number of channels that libsndfile reads; it is
            resampled if the device does not take its rate.
        stopped: once it is set, by another thread, the rest is left out.

    Raises:
        AudioError: the file cannot be read, or there is no loudspeaker that plays it.
    """
    sounddevice = load_sounddevice()
    try:
        with path.open("rb") as stream, soundfile.SoundFile(stream) as file:
            rate = _device_rate(sounddevice, file)
            with sounddevice.OutputStream(rate, channels=file.channels, dtype="float32") as device:
                for block in _blocks(file, rate):
                    if stopped is not None and stopped.is_set():
                        return
                    device.write(block)
                device.write(np.zeros((int(TAIL_SECONDS * rate), file.channels), np.float32))
    except OSError as error:
        raise AudioError(f"{path}: cannot be read ({error.strerror})") from error
    except soundfile.LibsndfileError as error:
        reason = error.error_string.rstrip(".")
        raise AudioError(f"{path}: is no recording that can be read ({reason})") from error
    except sounddevice.PortAudioError as error:
        reason = " ".join(str(error).split())
        raise AudioError(f"the loudspeaker fails ({reason}); check the sound settings") from error


def load_sounddevice() -> ModuleType:
    """Import the binding to PortAudio; raises AudioError if that is not installed."""
    try:
        import sounddevice  # looks for devices as it is imported, which takes its time
    except OSError as error:
        raise AudioError(
            "PortAudio is not installed; install it with: sudo apt-get install libportaudio2"
        ) from error
    module: ModuleType = sounddevice
    return module


def _device_rate(sounddevice: ModuleType, file: soundfile.SoundFile) -> int:
    """The rate to play a file at, Hz: its own, or the device's if that takes no other."""
    try:
        device = sounddevice.query_devices(kind="output")
    except sounddevice.PortAudioError as error:
        raise AudioError("there is no loudspeaker; connect one and start again") from error
    try:
        sounddevice.check_output_settings(
            channels=file.channels, dtype="float32", samplerate=file.samplerate
        )
    except sounddevice.PortAudioError:
        return int(device["default_samplerate"])
    return int(file.samplerate)


def _blocks(file: soundfile.SoundFile, rate: int) -> Iterator[npt.NDArray[np.float32]]:
    size = int(BLOCK_SECONDS * file.samplerate) + 1
    blocks = file.blocks(size, dtype="float32", always_2d=True)
    if rate == file.samplerate:
        yield from blocks
        return
    import soxr  # 20 ms that a file at the device's rate need not wait for

    resampler = soxr.ResampleStream(file.samplerate, rate, file.channels, dtype="float32")
    for block in blocks:
        yield resampler.resample_chunk(block)
    nothing = np.empty((0, file.channels), np.float32)
    yield resampler.resample_chunk(nothing, last=True)
