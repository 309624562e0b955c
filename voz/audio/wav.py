"""WAV as it comes from a file or a pipe: its header, and samples of all widths.

libsndfile needs a file that it can seek in, and believes a length of 0 that a recorder meant to
fill in when it ended.
"""

from __future__ import annotations

import io
import shutil
import struct
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

PCM = 1
EXTENSIBLE = 0xFFFE
"""The real format stands in the first two bytes of the GUID that follows."""

MAX_HEADER_CHUNK = 1 << 24
"""Bytes; a chunk before the samples may hold a picture."""

UNKNOWN_WAV_LENGTH = 0x7FFFF000
"""A program that writes a WAV to a pipe promises at least this many bytes."""

PCM_WIDTHS = (1, 2, 3, 4)
"""Bytes of a sample."""

_CHUNK = struct.Struct("<4sI")
_FORMAT = struct.Struct("<HHIIHH")


class WavHeader(NamedTuple):
    """What stands before the samples of a WAV file."""

    encoding: int  # number of the format, 1 for PCM
    channels: int  # their number
    rate: int  # Hz
    frame_bytes: int  # of a sample of each channel
    samples_at: int  # where the samples begin, bytes
    data_bytes: int  # length of the samples as the header has it

    @property
    def width(self) -> int:
        """Bytes of a sample; 0 if the header contradicts itself."""
        whole, rest = divmod(self.frame_bytes, max(1, self.channels))
        return whole if self.channels and not rest else 0

    @property
    def has_length(self) -> bool:
        """Whether the length of the samples is known; a recorder that was killed never wrote it."""
        return 0 < self.data_bytes < UNKNOWN_WAV_LENGTH


def read_wav_header(read: Callable[[int], bytes]) -> WavHeader | None:
    """Read up to the first sample of a WAV; None if it is none, or its header is damaged."""
    riff = read(12)
    if riff[:4] not in (b"RIFF", b"RF64") or riff[8:] != b"WAVE":
        return None
    at, layout, long_size = len(riff), b"", None
    while len(head := read(_CHUNK.size)) == _CHUNK.size:
        name, size = _CHUNK.unpack(head)
        at += _CHUNK.size
        if name == b"data":
            return _header(layout, at, size if long_size is None else long_size)
        if size > MAX_HEADER_CHUNK:
            return None
        size += size % 2
        content = read(size)
        at += size
        if name == b"fmt ":
            layout = content
        elif name == b"ds64" and len(content) >= 16:
            (long_size,) = struct.unpack_from("<Q", content, 8)
    return None


def pcm_samples(data: bytes, width: int, *, unsigned: bool = True) -> npt.NDArray[Any]:
    """Return samples of PCM, little-endian: int16 of 8 and 16 bits, else floats from -1 to 1.

    Args:
        data: whole samples.
        width: bytes of each, one of `PCM_WIDTHS`.
        unsigned: whether silence is 128 in those of 8 bits, as in WAV.
    """
    if width == 1:
        centered = np.frombuffer(data, np.uint8) ^ np.uint8(0x80 if unsigned else 0)
        wide: npt.NDArray[np.int16] = centered.view(np.int8).astype(np.int16) << 8
        return wide
    if width == 2:
        return np.frombuffer(data, "<i2")
    if width == 4:
        return (np.frombuffer(data, "<i4") / 2.0**31).astype(np.float32)
    padded = np.zeros((len(data) // width, 4), np.uint8)
    padded[:, 1:] = np.frombuffer(data, np.uint8).reshape(-1, width)
    return (padded.view("<i4")[:, 0] / 2.0**31).astype(np.float32)


def _header(layout: bytes, at: int, size: int) -> WavHeader | None:
    if len(layout) < _FORMAT.size:
        return None
    encoding, channels, rate, _, frame_bytes, _ = _FORMAT.unpack_from(layout)
    if encoding == EXTENSIBLE and len(layout) >= 26:
        (encoding,) = struct.unpack_from("<H", layout, 24)
    return WavHeader(encoding, channels, rate, frame_bytes, at, size)


def has_unsigned_bytes(data: bytes) -> bool:
    """Whether samples of 8 bits are as in WAV: then what is nearer to silence is nearer to 128."""
    samples = np.frombuffer(data, np.int8).astype(int)
    return bool(np.abs(samples).sum() > (128 - np.abs(samples)).sum())


@contextmanager
def with_length(file: io.FileIO) -> Iterator[io.FileIO]:
    """Yield a file whose header has the length of its samples: a copy of a WAV that has none.

    A recorder writes 0 at first; one that was killed leaves it so.
    """
    header = read_wav_header(file.read)
    rest = file.read(MAX_HEADER_CHUNK) if header and header.data_bytes == 0 else b""
    file.seek(0)
    if header is None or not header.frame_bytes or not rest or _is_chunks(rest):
        yield file
        return
    with tempfile.TemporaryFile(buffering=0) as copy:
        shutil.copyfileobj(file, copy)
        length = (copy.tell() - header.samples_at) // header.frame_bytes * header.frame_bytes
        copy.truncate(header.samples_at + length)
        _write_at(copy, 0, b"RIFF" + _size(header.samples_at + length - 8))
        _write_at(copy, header.samples_at - 4, _size(length))
        copy.seek(0)
        yield copy


def _is_chunks(data: bytes) -> bool:
    """Whether bytes are whole chunks of a WAV, as behind samples; sound is that only by chance."""
    at = 0
    while at < len(data):
        if len(data) - at < _CHUNK.size:
            return False
        name, size = _CHUNK.unpack_from(data, at)
        if not (name.isascii() and name.decode().isprintable()):
            return False
        at += _CHUNK.size + size + size % 2
    return at in (len(data), len(data) + 1)


def _size(size: int) -> bytes:
    return struct.pack("<I", min(size, UNKNOWN_WAV_LENGTH))


def _write_at(file: io.FileIO, at: int, data: bytes) -> None:
    file.seek(at)
    file.write(data)
