"""Recordings of any format and arrays of any rate and channels, as 16 kHz mono."""

from __future__ import annotations

import logging
import os
import re
import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import soundfile

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.channels import OUT_OF_PHASE, ChannelMixer, Mono
from voz.audio.wav import UNKNOWN_WAV_LENGTH, with_length
from voz.errors import AudioError
from voz.files import shown_path
from voz.printable import shown_value
from voz.records import is_finite

READ_BLOCK_SECONDS = 1.0
"""Long enough for speed, short enough that memory does not depend on the length."""

MIN_SAMPLE_RATE, MAX_SAMPLE_RATE = 4000, 768_000
"""Hz; below there is no speech, above the header is broken."""

MAX_FLOAT_SAMPLE = 4.0
"""Floats go from -1 to 1, and a little beyond where a recording is too loud."""

LOUDEST_MIX = 64.0
"""Floats beyond this are integers that were not scaled; up to it, a recording is far too loud."""

INTEGER_SCALES = (2.0**15, 2.0**23, 2.0**31)
"""What integers of 16, 24 and 32 bits are divided by; floats beyond are damaged, and cut off."""

LOUDEST_FLOAT = 32768.0
"""Beyond this, sums of floats overflow."""

MAX_SOUND_SECONDS = 600.0
"""A sound that is played is held in memory, 12 MB a minute."""

OGG_MAX_PAGE_BYTES = 65_307
"""The longest page of an OGG file."""

OGG_HEADER = 27
"""Bytes; the last one is the number of segment lengths that follow."""

OGG_LAST_PAGE_FLAG = 4
"""In the sixth byte of a page."""

UNKNOWN_FRAMES = 2**62
"""libsndfile's length of a FLAC that has none in its header is larger."""

MISSING_SECONDS, MISSING_MPEG_SECONDS = 0.05, 0.25
"""A recording that is shorter than its header has it is cut short; MPEG's is an estimate."""

READABLE = "aif aifc aiff au caf flac mp2 mp3 oga ogg opus rf64 snd sph voc w64 wav"
UNREADABLE = (
    "3g2 3ga 3gp aac aax ac3 adts alac amr ape asf avi awb dff dsf dss eac3 flv gsm m4a m4b m4r "
    "m4v mka mkv mov mp4 mpc mpeg mpg ogv oma qcp ra rm sln spx tta vob weba webm wma wmv wv"
)

ENDINGS = frozenset(f".{name}" for name in READABLE.split())
"""Of files that libsndfile reads."""

UNREADABLE_ENDINGS = frozenset(f".{name}" for name in UNREADABLE.split())
"""Of files with sound that it does not read, and ffmpeg does."""

_log = logging.getLogger("voz")

Warn = Callable[[str], None]
"""Takes a line about a recording that is read all the same."""


def convert_advice(path: Path) -> str | None:
    """What to do with a file whose ending says that libsndfile does not read it; else nothing."""
    if path.suffix.lower() not in UNREADABLE_ENDINGS:
        return None
    names = (shlex.quote(shown_path(each)) for each in (path, path.with_suffix(".wav")))
    return "convert it with: ffmpeg -i {} {}".format(*names)


def read_blocks(path: Path, warn: Warn = _log.warning) -> Iterator[Samples]:
    """Read a recording of any format, rate and channels in blocks of up to a second, 16 kHz.

    `warn` takes a line, with the file's name, if it is read otherwise than it stands there.

    Raises:
        AudioError: it cannot be read, is empty, cut short, or holds samples that are no numbers.
    """
    with _open(path) as file:
        read = 0
        for block in _read_from(path, file, warn):
            read += len(block)
            yield block
        _check_whole(path, file, read / SAMPLE_RATE)


def read_samples(path: Path, warn: Warn = _log.warning) -> Samples:
    """Read a whole recording, as `read_blocks` does."""
    return np.concatenate(list(read_blocks(path, warn)))


def read_sound(path: Path, rate: int) -> npt.NDArray[np.float32]:
    """Read a sound to be played, resampled to `rate`, Hz; raises AudioError if it is too long."""
    with _open(path) as file:
        if MAX_SOUND_SECONDS * file.samplerate < file.frames < UNKNOWN_FRAMES:
            minutes = f"{MAX_SOUND_SECONDS / 60:g} minutes"
            raise AudioError(f"{shown_path(path)}: is longer than {minutes}; play a part of it")
        sound = np.concatenate(list(_read_resampled(path, file, rate, _log.warning)))
        _check_whole(path, file, len(sound) / rate)
    return sound


class _SoundStream(soundfile.SoundFile):  # type: ignore[misc]
    """A recording that is read to its end, not to the length that its header has.

    soundfile seeks after each read, which fails in a FLAC that came from a pipe.
    """

    def seekable(self) -> bool:
        return False


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
            path.open("rb", buffering=0) as opened,
            with_length(opened) as stream,
            _SoundStream(stream.fileno(), closefd=False) as file,
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
        what = f"{shown_path(path)}: is no recording that can be read ({reason})"
        raise AudioError(what, convert_advice(path)) from error


def _check_whole(path: Path, file: soundfile.SoundFile, seconds: float) -> None:
    missing = _header_seconds(file) - seconds
    is_mpeg = file.subtype.startswith("MPEG")
    if missing > (MISSING_MPEG_SECONDS if is_mpeg else MISSING_SECONDS):
        raise AudioError(f"{shown_path(path)}: is cut short, the last {missing:.1f} s are missing")
    if file.format == "OGG" and not _has_last_ogg_page(path):
        raise AudioError(f"{shown_path(path)}: is cut short, its end is missing")
    if seconds == 0:
        raise AudioError(f"{shown_path(path)}: holds no sound")


def _is_native(file: soundfile.SoundFile) -> bool:
    return (file.samplerate, file.channels, file.subtype) == (SAMPLE_RATE, 1, "PCM_16")


def _read_from(path: Path, file: soundfile.SoundFile, warn: Warn) -> Iterator[Samples]:
    if _is_native(file):
        yield from _read_native(file)
    else:
        yield from filter(len, map(to_int16, _read_resampled(path, file, SAMPLE_RATE, warn)))


def _read_native(file: soundfile.SoundFile) -> Iterator[Samples]:
    # Not `file.blocks`, which repeats the last block where a file is damaged.
    while len(block := file.read(int(READ_BLOCK_SECONDS * SAMPLE_RATE), dtype="int16")):
        yield block


def _read_resampled(path: Path, file: soundfile.SoundFile, rate: int, warn: Warn) -> Iterator[Mono]:
    import soxr  # takes 20 ms, and 16 kHz needs none

    resampler = soxr.ResampleStream(file.samplerate, rate, 1, dtype="float32")
    mixer = ChannelMixer(file.samplerate)
    scale = _full_scale(path, file, warn)
    for channels in _read_floats(file):
        if not np.isfinite(channels).all():
            raise AudioError(
                f"{shown_path(path)}: holds samples that are no numbers; export it again"
            )
        if scale != 1:
            channels /= scale
        mono = mixer.feed(np.clip(channels, -LOUDEST_FLOAT, LOUDEST_FLOAT))
        yield resampler.resample_chunk(mono)
    if mixer.out_of_phase:
        warn(f"{shown_path(path)}: {OUT_OF_PHASE}")
    yield resampler.resample_chunk(mixer.finish(), last=True)


def _read_floats(file: soundfile.SoundFile) -> Iterator[npt.NDArray[np.float32]]:
    size = int(READ_BLOCK_SECONDS * file.samplerate) // file.channels + 1
    while len(channels := file.read(size, dtype="float32", always_2d=True)):
        yield channels


def _full_scale(path: Path, file: soundfile.SoundFile, warn: Warn) -> float:
    """Find what the samples of a file are to be divided by; floats may be integers unscaled."""
    if file.subtype not in ("FLOAT", "DOUBLE"):
        return 1.0
    peak = max((float(np.abs(block).max()) for block in _read_floats(file)), default=0.0)
    file.seek(0)
    if not peak > MAX_FLOAT_SAMPLE:  # NaN is an error later
        return 1.0
    scales = (peak,) if peak <= LOUDEST_MIX else INTEGER_SCALES
    scale = next((each for each in scales if peak <= each), 1.0)
    how = "cuts them off" if scale == 1 else f"divides by {scale:g}"
    shown = shown_path(path)
    warn(f"{shown}: has samples up to {peak:g}, where 1 is full scale; voz {how}")
    return scale


def to_int16(samples: npt.NDArray[np.floating[Any]]) -> Samples:
    """Convert samples from -1 to 1 to 16 bits, with clipping."""
    # Clipped first: the floats of a broken driver overflow.
    whole: Samples = np.minimum(np.rint(np.clip(samples, -1, 1) * 32768), 32767).astype(np.int16)
    return whole


def _header_seconds(file: soundfile.SoundFile) -> float:
    """Read the length that the header promises: libsndfile cuts a WAV's to what is there.

    Its log has both: `data : 32000 (should be 19956)`.
    """
    if file.frames >= UNKNOWN_FRAMES:
        return 0.0
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


class ArrayConverter:
    """Converts a stream of arrays to `Samples`, block by block."""

    def __init__(self, rate: float | None, warn: Warn = _log.warning) -> None:
        """Start a stream of arrays at a rate, Hz; raises AudioError if the rate is unusable.

        `warn` takes a line if channels would cancel each other, once.
        """
        if rate is None:
            raise AudioError("an array does not hold its sample rate; give it, as in rate=44100")
        if not _is_usable(rate):
            raise AudioError(
                f"a sample rate of {shown_value(rate)} Hz is not usable; give one from "
                f"{MIN_SAMPLE_RATE} to {MAX_SAMPLE_RATE} Hz"
            )
        self._mixer = ChannelMixer(float(rate))
        self._resampler = Resampler(rate)
        self._warn: Warn | None = warn
        self._finished = False

    def feed(self, array: npt.ArrayLike) -> Samples:
        """Convert samples, or samples x channels: int16, or floats from -1 to 1.

        Returns them as one channel; its last samples may come later. Raises AudioError.
        """
        if self._finished:
            raise AudioError("this stream is finished; begin another one")
        mono = self._mixer.feed(_channels(_as_array(array)))
        if self._mixer.out_of_phase and self._warn:
            self._warn(f"sound: {OUT_OF_PHASE}")
            self._warn = None
        return self._resampler.feed(mono)

    def finish(self) -> Samples:
        """End the stream; return its last samples, at a second call none."""
        if self._finished:
            return np.empty(0, np.int16)
        self._finished = True
        last = self._resampler.feed(self._mixer.finish())
        return np.concatenate([last, self._resampler.finish()])


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


def _channels(array: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    if array.ndim not in (1, 2):
        raise AudioError(f"an array of shape {array.shape} is no sound; give samples x channels")
    if array.ndim == 2 and not 0 < array.shape[1] <= MAX_CHANNELS:
        raise AudioError(f"an array of shape {array.shape} is no samples x channels; turn it round")
    scaled: npt.NDArray[np.float32]
    if array.dtype == np.int16:
        scaled = array.astype(np.float32) / np.float32(32768)
    elif array.dtype.kind == "f":
        scaled = _checked(array).astype(np.float32)
    else:
        raise AudioError(f"samples are {array.dtype}; give int16, or floats from -1 to 1")
    return scaled[:, None] if scaled.ndim == 1 else scaled


def _checked(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if not np.isfinite(array).all():
        raise AudioError("the sound holds samples that are no numbers; leave them out")
    loudest = float(np.abs(array).max(initial=0))
    if loudest > MAX_FLOAT_SAMPLE:
        raise AudioError(f"floats go from -1 to 1, and one is {loudest:g}; divide by 32768?")
    return array
