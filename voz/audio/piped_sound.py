"""Sound from a pipe: samples, or a recording; PCM is read as it comes."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from io import BufferedReader
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from voz.audio import Samples
from voz.audio.sound_files import MAX_CHANNELS, ArrayConverter, Warn, read_blocks
from voz.audio.wav import PCM, PCM_WIDTHS, WavHeader, pcm_samples, read_wav_header
from voz.errors import AudioError
from voz.files import shown_path

PIPE_BLOCK_SECONDS = 0.1
"""Sound is read in blocks of this length, s, and so delayed by it."""

SAMPLE_BYTES = 2

MOST_PIPED_BYTES = 4_000_000_000
"""Of a recording that is read as a whole: a pipe may be endless."""

COPY_BYTES = 1 << 16

SOUND_BEGINNINGS = (b"fLaC", b"OggS", b"FORM", b".snd", b"caff", b"riff", b"ID3")
"""Of recordings besides WAV that libsndfile reads; MP3 without a title begins with eleven ones."""


def is_sound(stream: BufferedReader) -> bool:
    """Whether a recording comes in a stream, and no list of names; nothing is consumed."""
    begins = stream.peek(16)[:16]
    if begins.startswith((b"RIFF", b"RF64")):
        return True
    is_mp3 = len(begins) > 1 and begins[0] == 0xFF and begins[1] >= 0xE0
    return is_mp3 or (begins.startswith(SOUND_BEGINNINGS) and b"\0" in begins)


def piped_blocks(
    stream: BufferedReader, rate: float | None, warn: Warn = lambda _: None
) -> Iterator[Samples]:
    """Read sound from a pipe; yields blocks of samples, 16 kHz. PCM is read as it comes.

    Args:
        stream: 16-bit samples of one channel, little-endian; without a rate, a recording of any
            format.
        rate: of the samples, Hz.
        warn: as for `read_blocks`.

    Raises:
        AudioError: it cannot be read, is empty, or the rate is too low for speech.
    """
    if rate is not None:
        yield from _converted(_raw(stream, rate), ArrayConverter(rate, warn))
        return
    begun = bytearray()

    def read(size: int) -> bytes:
        data = stream.read(size)
        begun.extend(data)
        return data

    header = read_wav_header(read)
    if header is None or header.encoding != PCM or header.width not in PCM_WIDTHS:
        yield from _whole(bytes(begun), stream, warn)
        return
    if header.channels > MAX_CHANNELS:
        raise AudioError(f"-: has {header.channels} channels; pipe one")
    yield from _converted(_pcm(stream, header), ArrayConverter(header.rate, warn))


def _converted(arrays: Iterable[npt.NDArray[Any]], converter: ArrayConverter) -> Iterator[Samples]:
    empty = True
    for array in arrays:
        empty = False
        yield converter.feed(array)
    if empty:
        raise AudioError("-: holds no sound")
    yield converter.finish()


def _raw(stream: BufferedReader, rate: float) -> Iterator[npt.NDArray[np.int16]]:
    rest = b""
    while piece := stream.read1(int(rate * PIPE_BLOCK_SECONDS) * SAMPLE_BYTES):
        data = rest + piece
        whole = len(data) // SAMPLE_BYTES * SAMPLE_BYTES
        rest = data[whole:]
        if whole:
            yield np.frombuffer(data[:whole], "<i2")


def _pcm(stream: BufferedReader, header: WavHeader) -> Iterator[npt.NDArray[Any]]:
    """Read the samples of a WAV, to the end of the pipe if it has no length."""
    left = header.data_bytes if header.has_length else None
    size = max(1, int(header.rate * PIPE_BLOCK_SECONDS)) * header.frame_bytes
    while data := stream.read(size if left is None else min(size, left)):
        if left is not None:
            left -= len(data)
        whole = len(data) // header.frame_bytes * header.frame_bytes
        if whole:
            samples = pcm_samples(data[:whole], header.width)
            yield samples.reshape(-1, header.channels)


def _whole(begun: bytes, stream: BufferedReader, warn: Warn) -> Iterator[Samples]:
    """Read a recording of another format than PCM, once all of it is there."""
    with tempfile.NamedTemporaryFile(prefix="voz-") as file:
        file.write(begun)
        while data := stream.read(COPY_BYTES):
            file.write(data)
            if file.tell() > MOST_PIPED_BYTES:
                raise AudioError(f"-: is larger than {MOST_PIPED_BYTES / 1e9:g} GB; cut it")
        file.flush()
        path = Path(file.name)
        try:
            yield from read_blocks(path, lambda problem: warn(_renamed(problem, path)))
        except AudioError as error:
            raise AudioError(_renamed(str(error), path)) from error


def _renamed(message: str, path: Path) -> str:
    return message.replace(shown_path(path), "-")
