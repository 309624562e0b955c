"""Decodes recordings, and sound from a pipe, each as if it were alone."""

from __future__ import annotations

import time
import wave
from collections.abc import Callable, Iterable, Iterator
from io import BufferedReader
from pathlib import Path

import numpy as np
import numpy.typing as npt

from voz.apps.batch.outcomes import ErrorRow, Outcome, Row, make_outcome, utterance_row
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import MAX_CHANNELS, ArrayConverter, read_blocks
from voz.errors import AudioError
from voz.files import shown_path
from voz.recognition.engine import RecognitionEngine
from voz.recognition.interpreter import NO_DETAILS, Details


def decode_recording(
    recognizer: RecognitionEngine,
    path: Path,
    file: str | None = None,
    details: Details = NO_DETAILS,
) -> Outcome:
    """Decode one recording as if it were alone; its rows name it by `file`, or else by its path.

    The rows are its utterances, then the error if reading it failed; one `SilentRow` if nothing
    was said.
    """
    return decode_blocks(recognizer, read_blocks(path), file or shown_path(path), details)


def decode_blocks(
    recognizer: RecognitionEngine,
    blocks: Iterable[Samples],
    file: str,
    details: Details = NO_DETAILS,
    on_row: Callable[[Row], None] = lambda _: None,
) -> Outcome:
    """Decode one recording, 16 kHz, whose rows name it `file`; the blocks may end in an AudioError.

    `on_row` is called with each row as soon as it is known; `details` are what rows have besides.
    """
    before = time.process_time()
    heard = 0

    def counted() -> Iterator[Samples]:
        nonlocal heard
        for block in blocks:
            heard += len(block)
            yield block

    rows: list[Row] = []

    def add(row: Row) -> None:
        rows.append(row)
        on_row(row)

    try:
        for utterance in recognizer.utterances(counted(), file, details):
            add(utterance_row(utterance, file))
    except AudioError as error:
        add(ErrorRow(file, str(error)))
    return make_outcome(file, tuple(rows), heard / SAMPLE_RATE, time.process_time() - before)


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
