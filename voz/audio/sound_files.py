"""Recordings of any format and arrays of any rate and channels, as 16 kHz mono."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import soundfile

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError
from voz.files import shown_path
from voz.printable import shown_value
from voz.records import is_finite

READ_BLOCK_SECONDS = 1.0
"""Long enough for speed, short enough that memory does not depend on the length."""

MIN_SAMPLE_RATE, MAX_SAMPLE_RATE = 4000, 768_000
"""Hz; below there is no speech, above the header is broken."""

LOUDEST_FLOAT = 32768.0
"""Floats go from -1 to 1; those that were not scaled go up to this, and above, sums overflow."""

MAX_SOUND_SECONDS = 600.0
"""A sound that is played is held in memory, 12 MB a minute."""

OGG_MAX_PAGE_BYTES = 65_307
"""The longest page of an OGG file."""

OGG_HEADER = 27
"""Bytes; the last one is the number of segment lengths that follow."""

OGG_LAST_PAGE_FLAG = 4
"""In the sixth byte of a page."""

UNKNOWN_WAV_LENGTH = 0x7FFFF000
"""A program that writes a WAV to a pipe promises at least this many bytes."""


def read_blocks(path: Path) -> Iterator[Samples]:
    """Read a recording of any format, rate and channels in blocks of up to a second, 16 kHz.

    Raises:
        AudioError: it cannot be read, is empty, cut short, or holds samples that are no numbers.
    """
    with _open(path) as file:
        read = 0
        for block in _read_from(path, file):
            read += len(block)
            yield block
        _check_whole(path, file, read / SAMPLE_RATE)


def read_sound(path: Path, rate: int) -> npt.NDArray[np.float32]:
    """Read a sound to be played, resampled to `rate`, Hz; raises AudioError if it is too long."""
    with _open(path) as file:
        if file.frames > MAX_SOUND_SECONDS * file.samplerate:
            minutes = f"{MAX_SOUND_SECONDS / 60:g} minutes"
            raise AudioError(f"{shown_path(path)}: is longer than {minutes}; play a part of it")
        sound = np.concatenate(list(_read_resampled(path, file, rate)))
        _check_whole(path, file, len(sound) / rate)
    return sound


@contextmanager
def _open(path: Path) -> Iterator[soundfile.SoundFile]:
    """Open a recording; errors in the block become an AudioError, too."""
    try:
        if path.is_dir():
            raise AudioError(f"{shown_path(path)}: is a folder; name the recordings in it")
        if not path.exists():
            raise AudioError(f"{shown_path(path)}: there is no such file")
        if not path.is_file():
            raise AudioError(
                f"{shown_path(path)}: is no regular file; save the recording to disk first"
            )
        # An open file: from its name libsndfile would guess `.raw`, and fail at accents. By its
        # descriptor: errors of a Python file that libsndfile reads are tracebacks.
        with (
            path.open("rb", buffering=0) as stream,
            soundfile.SoundFile(stream.fileno(), closefd=False) as file,
        ):
            if not MIN_SAMPLE_RATE <= file.samplerate <= MAX_SAMPLE_RATE:
                raise AudioError(
                    f"{shown_path(path)}: a sample rate of {file.samplerate} Hz is not usable; "
                    "record at 16000 Hz"
                )
            yield file
    except OSError as error:
        raise AudioError(f"{shown_path(path)}: cannot be read ({error.strerror})") from error
    except soundfile.LibsndfileError as error:
        reason = error.error_string.rstrip(".")
        raise AudioError(
            f"{shown_path(path)}: is no recording that can be read ({reason})"
        ) from error


def _check_whole(path: Path, file: soundfile.SoundFile, seconds: float) -> None:
    missing = _header_seconds(file) - seconds
    if missing > 0.01:
        raise AudioError(f"{shown_path(path)}: is cut short, the last {missing:.1f} s are missing")
    if file.format == "OGG" and not _has_last_ogg_page(path):
        raise AudioError(f"{shown_path(path)}: is cut short, its end is missing")
    if seconds == 0:
        raise AudioError(f"{shown_path(path)}: holds no sound")


def _is_native(file: soundfile.SoundFile) -> bool:
    return (file.samplerate, file.channels, file.subtype) == (SAMPLE_RATE, 1, "PCM_16")


def _read_from(path: Path, file: soundfile.SoundFile) -> Iterator[Samples]:
    if _is_native(file):
        yield from _read_native(file)
    else:
        yield from filter(len, map(to_int16, _read_resampled(path, file)))


def _read_native(file: soundfile.SoundFile) -> Iterator[Samples]:
    # Not `file.blocks`, which repeats the last block where a file is damaged.
    while len(block := file.read(int(READ_BLOCK_SECONDS * SAMPLE_RATE), dtype="int16")):
        yield block


def _read_resampled(
    path: Path, file: soundfile.SoundFile, rate: int = SAMPLE_RATE
) -> Iterator[npt.NDArray[np.float32]]:
    import soxr  # takes 20 ms, and 16 kHz needs none

    resampler = soxr.ResampleStream(file.samplerate, rate, 1, dtype="float32")
    size = int(READ_BLOCK_SECONDS * file.samplerate) // file.channels + 1
    while len(channels := file.read(size, dtype="float32", always_2d=True)):
        if not np.isfinite(channels).all():
            raise AudioError(
                f"{shown_path(path)}: holds samples that are no numbers; export it again"
            )
        mono = np.clip(channels, -LOUDEST_FLOAT, LOUDEST_FLOAT).mean(axis=1)
        yield resampler.resample_chunk(mono)
    yield resampler.resample_chunk(np.empty(0, np.float32), last=True)


def to_int16(samples: npt.NDArray[np.floating[Any]]) -> Samples:
    """Convert samples from -1 to 1 to 16 bits, with clipping."""
    whole: Samples = np.clip(np.rint(samples * 32768), -32768, 32767).astype(np.int16)
    return whole


def _header_seconds(file: soundfile.SoundFile) -> float:
    """Read the length that the header promises: libsndfile cuts a WAV's to what is there.

    Its log has both: `data : 32000 (should be 19956)`.
    """
    seconds = float(file.frames / file.samplerate)
    log = re.search(r"^data : (\d+) \(should be (\d+)\)", file.extra_info, re.MULTILINE)
    if log is None or int(log[1]) >= UNKNOWN_WAV_LENGTH:
        return seconds
    promised, there = int(log[1]), int(log[2])
    return seconds * promised / there if there else seconds


def _has_last_ogg_page(path: Path) -> bool:
    """Whether an OGG file's last page is marked as the last; only this shows whether it was cut."""
    with path.open("rb") as stream:
        stream.seek(-min(OGG_MAX_PAGE_BYTES, path.stat().st_size), os.SEEK_END)
        end = stream.read()
    page = end[max(0, end.rfind(b"OggS")) :]  # https://www.rfc-editor.org/rfc/rfc3533#section-6
    if len(page) < OGG_HEADER or not page[5] & OGG_LAST_PAGE_FLAG:
        return False
    segments = page[OGG_HEADER - 1]
    return len(page) >= OGG_HEADER + segments + sum(page[OGG_HEADER : OGG_HEADER + segments])


Mono = npt.NDArray[np.float32]


class Resampler:
    """Converts a stream of floats from -1 to 1 to `Samples`."""

    def __init__(self, rate: float) -> None:
        """Start a stream of this rate, Hz."""
        self._stream: Any = None
        if rate != SAMPLE_RATE:
            import soxr  # takes 20 ms, and 16 kHz needs none

            self._stream = soxr.ResampleStream(rate, SAMPLE_RATE, 1, dtype="float32")

    def feed(self, block: Mono) -> Samples:
        """Convert the next block; the resampler may keep its last samples for later."""
        return to_int16(self._stream.resample_chunk(block) if self._stream else block)

    def finish(self) -> Samples:
        """End the stream; returns its last samples."""
        nothing = np.empty(0, np.float32)
        return to_int16(
            self._stream.resample_chunk(nothing, last=True) if self._stream else nothing
        )


MAX_CHANNELS = 64

MAX_FLOAT_SAMPLE = 4.0
"""Floats beyond this are 16-bit values that were not scaled."""


class ArrayConverter:
    """Converts a stream of arrays to `Samples`, block by block."""

    def __init__(self, rate: float | None) -> None:
        """Start a stream of arrays at a rate, Hz; raises AudioError if the rate is unusable."""
        if rate is None:
            raise AudioError("an array does not hold its sample rate; give it, as in rate=44100")
        if not _is_usable(rate):
            raise AudioError(
                f"a sample rate of {shown_value(rate)} Hz is not usable; give one from "
                f"{MIN_SAMPLE_RATE} to {MAX_SAMPLE_RATE} Hz"
            )
        self._resampler = Resampler(rate)
        self._finished = False

    def feed(self, array: npt.ArrayLike) -> Samples:
        """Convert samples, or samples x channels: int16, or floats from -1 to 1.

        Returns the mean of the channels; its last samples may come later. Raises AudioError.
        """
        if self._finished:
            raise AudioError("this stream is finished; begin another one")
        return self._resampler.feed(_mono(_as_array(array)))

    def finish(self) -> Samples:
        """End the stream; return its last samples, at a second call none."""
        if self._finished:
            return np.empty(0, np.int16)
        self._finished = True
        return self._resampler.finish()


def to_samples(array: npt.ArrayLike, rate: float | None) -> Samples:
    """Convert a whole recording; arguments and errors are those of `ArrayConverter`."""
    converter = ArrayConverter(rate)
    return np.concatenate([converter.feed(array), converter.finish()])


def _is_usable(rate: object) -> bool:
    return is_finite(rate) and MIN_SAMPLE_RATE <= float(rate) <= MAX_SAMPLE_RATE  # type: ignore[arg-type]


def _as_array(array: npt.ArrayLike) -> npt.NDArray[Any]:
    try:
        return np.asarray(array)
    except (TypeError, ValueError, OverflowError) as error:  # rows of different lengths, for one
        raise AudioError(f"this is no array ({error})", "give samples x channels") from None


def _mono(array: npt.NDArray[Any]) -> Mono:
    if array.ndim not in (1, 2):
        raise AudioError(f"an array of shape {array.shape} is no sound; give samples x channels")
    if array.ndim == 2 and not 0 < array.shape[1] <= MAX_CHANNELS:
        raise AudioError(f"an array of shape {array.shape} is no samples x channels; turn it round")
    if array.dtype == np.int16:
        scaled = array.astype(np.float32) / np.float32(32768)
    elif array.dtype.kind == "f":
        scaled = _checked(array).astype(np.float32)
    else:
        raise AudioError(f"samples are {array.dtype}; give int16, or floats from -1 to 1")
    mono: Mono = scaled if scaled.ndim == 1 else scaled.mean(axis=1)
    return mono


def _checked(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if not np.isfinite(array).all():
        raise AudioError("the sound holds samples that are no numbers; leave them out")
    loudest = float(np.abs(array).max(initial=0))
    if loudest > MAX_FLOAT_SAMPLE:
        raise AudioError(f"floats go from -1 to 1, and one is {loudest:g}; divide by 32768?")
    return array
