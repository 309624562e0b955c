"""Sound from standard input: bare samples, or a WAV whose length is not known yet."""

from __future__ import annotations

import wave
from collections.abc import Iterator
from io import BufferedReader

import numpy as np
import numpy.typing as npt

from voz.audio import Samples
from voz.audio.sound_files import MAX_CHANNELS, ArrayConverter
from voz.errors import AudioError

PIPE_BLOCK_SECONDS = 0.1
"""Sound is read in blocks of this length, s, and so delayed by it."""

SAMPLE_BYTES = 2


def is_wav(stream: BufferedReader) -> bool:
    """Whether the stream is a WAV; nothing is consumed."""
    return stream.peek(4)[:4] == b"RIFF"


def piped_blocks(stream: BufferedReader, rate: float | None) -> Iterator[Samples]:
    """Read sound from a pipe as it comes; yields blocks of samples, 16 kHz.

    Args:
        stream: 16-bit samples of one channel, little-endian; without a rate, a WAV.
        rate: of the samples, Hz.

    Raises:
        AudioError: it is no such WAV, is empty, or the rate is too low for speech.
    """
    converter, arrays = _raw(stream, rate) if rate is not None else _wav(stream)
    empty = True
    for array in arrays:
        empty = False
        yield converter.feed(array)
    if empty:
        raise AudioError("-: holds no sound")
    yield converter.finish()


def _raw(
    stream: BufferedReader, rate: float
) -> tuple[ArrayConverter, Iterator[npt.NDArray[np.int16]]]:
    def arrays() -> Iterator[npt.NDArray[np.int16]]:
        rest = b""
        while piece := stream.read1(int(rate * PIPE_BLOCK_SECONDS) * SAMPLE_BYTES):
            data = rest + piece
            whole = len(data) // SAMPLE_BYTES * SAMPLE_BYTES
            rest = data[whole:]
            if whole:
                yield np.frombuffer(data[:whole], "<i2")

    return ArrayConverter(rate), arrays()


def _wav(stream: BufferedReader) -> tuple[ArrayConverter, Iterator[npt.NDArray[np.int16]]]:
    try:
        file = wave.open(stream, "rb")  # noqa: SIM115
    except (wave.Error, EOFError, RuntimeError) as error:
        reason = str(error) or "it ends in its header"
        raise AudioError(f"-: is no WAV that can be read ({reason}); pipe PCM") from error
    if file.getsampwidth() != SAMPLE_BYTES:
        raise AudioError(f"-: has samples of {8 * file.getsampwidth()} bits; pipe 16")
    channels = file.getnchannels()
    if channels > MAX_CHANNELS:
        raise AudioError(f"-: has {channels} channels; pipe one")

    def arrays() -> Iterator[npt.NDArray[np.int16]]:
        while data := file.readframes(max(1, int(file.getframerate() * PIPE_BLOCK_SECONDS))):
            whole = len(data) // (SAMPLE_BYTES * channels) * SAMPLE_BYTES * channels
            yield np.frombuffer(data[:whole], "<i2").reshape(-1, channels)

    return ArrayConverter(file.getframerate()), arrays()
