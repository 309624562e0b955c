"""Decodes recordings with one recognizer, each as if it were alone."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from voz.apps.batch.outcomes import ErrorRow, Outcome, Row, make_outcome, utterance_row
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_blocks
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
