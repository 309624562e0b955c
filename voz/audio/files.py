"""Recordings on disk: whatever libsndfile reads, as blocks of 16 kHz mono samples."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt
import soundfile

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError

BLOCK_SECONDS = 1.0
"""Long enough to be read fast, short enough that an hour needs no more memory than a second."""

LOWEST_RATE, HIGHEST_RATE = 4000, 768_000
"""Below the first there is no speech left, above the second no sound card: a broken header."""

UNKNOWN_LENGTH = 0x7FFFF000
"""A program that writes to a pipe does not know the length and promises at least this."""


def printable(path: Path) -> str:
    """A path as text that JSON can hold too, with escapes for what is no UTF-8 in it."""
    return os.fsencode(path).decode(errors="backslashreplace")


def read_blocks(path: Path) -> Iterator[Samples]:
    """Read a recording block by block.

    Args:
        path: a file in any format, rate and number of channels that libsndfile reads.

    Yields:
        Blocks of up to about a second, 16 kHz, mono (the mean of the channels), int16.

    Raises:
        AudioError: the file is missing, no regular file, unreadable, empty, cut short or holds
            samples that are no numbers. The blocks before the fault were yielded.
    """
    if path.is_dir():
        raise AudioError(f"{printable(path)}: is a folder; name the recordings in it")
    if not path.exists():
        raise AudioError(f"{printable(path)}: there is no such file")
    if not path.is_file():
        raise AudioError(f"{printable(path)}: is no regular file; save the recording to disk first")
    try:
        # An open file: by its name alone libsndfile would guess at `.raw` and stumble over accents.
        with path.open("rb") as stream, soundfile.SoundFile(stream) as file:
            yield from _blocks_of(path, file)
    except OSError as error:
        raise AudioError(f"{printable(path)}: cannot be read ({error.strerror})") from error
    except soundfile.LibsndfileError as error:
        reason = error.error_string.rstrip(".")
        raise AudioError(
            f"{printable(path)}: is no recording that can be read ({reason})"
        ) from error


def _blocks_of(path: Path, file: soundfile.SoundFile) -> Iterator[Samples]:
    rate = file.samplerate
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:
        raise AudioError(
            f"{printable(path)}: a sample rate of {rate} Hz is not usable; record at 16000 Hz"
        )
    read = 0
    for block in _native(file) if _is_native(file) else _converted(path, file):
        read += len(block)
        yield block
    missing = _promised_seconds(file) - read / SAMPLE_RATE
    if missing > 0.01:
        raise AudioError(f"{printable(path)}: is cut short, the last {missing:.1f} s are missing")
    if read == 0:
        raise AudioError(f"{printable(path)}: holds no sound")


def _is_native(file: soundfile.SoundFile) -> bool:
    return (file.samplerate, file.channels, file.subtype) == (SAMPLE_RATE, 1, "PCM_16")


def _native(file: soundfile.SoundFile) -> Iterator[Samples]:
    yield from file.blocks(int(BLOCK_SECONDS * SAMPLE_RATE), dtype="int16")


def _converted(path: Path, file: soundfile.SoundFile) -> Iterator[Samples]:
    import soxr  # 20 ms that the usual 16 kHz recording need not wait for

    resampler = soxr.ResampleStream(file.samplerate, SAMPLE_RATE, 1, dtype="float32")
    size = int(BLOCK_SECONDS * file.samplerate) // file.channels + 1
    for channels in file.blocks(size, dtype="float32", always_2d=True):
        mono = channels.mean(axis=1)
        if not np.isfinite(mono).all():
            raise AudioError(
                f"{printable(path)}: holds samples that are no numbers; export it again"
            )
        yield to_int16(resampler.resample_chunk(mono))
    yield to_int16(resampler.resample_chunk(np.empty(0, np.float32), last=True))


def to_int16(samples: npt.NDArray[np.float32]) -> Samples:
    """Turn samples from -1 to 1 into 16 bits; what is beyond is clipped."""
    return np.clip(np.rint(samples * 32768), -32768, 32767).astype(np.int16)


def _promised_seconds(file: soundfile.SoundFile) -> float:
    """How long the header says the recording is; libsndfile itself cuts a WAV's to what is there.

    Its log keeps what it read: `data : 32000 (should be 19956)`.
    """
    seconds = float(file.frames / file.samplerate)
    log = re.search(r"^data : (\d+) \(should be (\d+)\)", file.extra_info, re.MULTILINE)
    if log is None or int(log[1]) >= UNKNOWN_LENGTH:
        return seconds
    promised, there = int(log[1]), int(log[2])
    return seconds * promised / there if there else seconds
