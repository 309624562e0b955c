"""The work of a worker: decodes recordings, each as if it were alone.

The models are loaded once, and a bad recording is only a row.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import msgspec
from msgspec.structs import replace

from voz.apps.batch.fingerprint import check_same
from voz.apps.batch.locations import LocalRecording, local_recording, shown_name
from voz.apps.batch.outcomes import (
    ErrorRow,
    Outcome,
    Row,
    failed_outcome,
    make_outcome,
    utterance_row,
)
from voz.apps.batch.stamps import stamp_of, with_checksum
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_blocks
from voz.errors import AudioError, VozError
from voz.files import shown_path
from voz.language.language_files import LanguageFiles
from voz.recognition.engine import RecognitionEngine
from voz.recognition.interpreter import NO_DETAILS, Details
from voz.recognition.profiles import load_profile
from voz.settings import Recognition


class SimulationOptions(msgspec.Struct, frozen=True):
    """How recordings drive."""

    folder: str  # for the events and pictures
    settings: bytes  # all of them, as JSON
    listening: bool = False  # whether commands are obeyed before a `start speech`
    pictures: bool = False  # whether the ways are drawn


class WorkerSetup(msgspec.Struct, frozen=True):
    """What all workers are told once."""

    folder: str  # the language files
    settings: Recognition
    profile: str | None = None  # the name of a speaker's
    memory: int | None = None  # that a worker may need besides the models, bytes; None is no limit
    fingerprint: str | None = None  # a worker with another one refuses
    base: str = ""  # the folder that paths are relative to, on a cluster
    simulation: SimulationOptions | None = None  # None if recordings drive no robot
    details: Details = NO_DETAILS  # what rows have besides


BYTES_PER_MEGABYTE = 1_000_000


def work(setup: WorkerSetup, names: Sequence[str]) -> tuple[Outcome, ...]:
    """Decode recordings, named by their paths and addresses, with any error as the last row.

    Raises:
        VozError: the models cannot be loaded, or differ from those of the output.
    """
    recognizer = _loaded(setup)
    return tuple(_decoded(recognizer, name, setup) for name in names)


def _decoded(recognizer: RecognitionEngine, name: str, setup: WorkerSetup) -> Outcome:
    # Made before it is read: if it changes meanwhile, the next run finds another stamp.
    stamp = stamp_of(name, setup.base)
    try:
        with _errors_as_audio_error(name, setup.memory), local_recording(name, setup.base) as found:
            stamp = stamp and with_checksum(stamp, found.path)
            outcome = _heard(recognizer, found, setup)
            warnings = tuple(_renamed(each, found) for each in outcome.warnings)
            rows = _named(outcome.rows, found)
            return replace(outcome, rows=rows, stamp=stamp, warnings=warnings)
    except AudioError as error:
        return failed_outcome(shown_name(name), str(error), stamp)


def _heard(recognizer: RecognitionEngine, found: LocalRecording, setup: WorkerSetup) -> Outcome:
    if setup.simulation is None:
        return decode_recording(recognizer, found.path, found.name, setup.details)
    from voz.apps.batch.simulated_run import simulate_recording

    return simulate_recording(recognizer, found, setup.simulation, setup.details)


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
    warnings: list[str] = []
    blocks = read_blocks(path, warnings.append)
    outcome = decode_blocks(recognizer, blocks, file or shown_path(path), details)
    return replace(outcome, warnings=tuple(warnings))


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


@contextmanager
def _errors_as_audio_error(name: str, memory: int | None) -> Iterator[None]:
    """Turn any exception into an AudioError: it must not cost the other recordings."""
    shown = shown_name(name)
    try:
        yield
    except VozError:
        raise
    except MemoryError as error:
        limit = f"{(memory or 0) // BYTES_PER_MEGABYTE} MB of memory"
        raise AudioError(f"{shown}: needs more than {limit}; raise --memory-limit") from error
    except Exception as error:  # a bug of a library
        reason = f"{type(error).__name__}: {error}"
        raise AudioError(f"{shown}: cannot be decoded ({reason})") from error


def _named(rows: tuple[Row, ...], found: LocalRecording) -> tuple[Row, ...]:
    """Name in an error what the user named, not the temporary file."""
    if not rows or not isinstance(last := rows[-1], ErrorRow):
        return rows
    return (*rows[:-1], ErrorRow(last.file, _renamed(last.error, found)))


def _renamed(message: str, found: LocalRecording) -> str:
    return message.replace(shown_path(found.path), found.name)


@cache
def _loaded(setup: WorkerSetup) -> RecognitionEngine:
    known = load_profile(setup.profile) if setup.profile else None
    language = LanguageFiles(Path(setup.folder))
    if setup.fingerprint:
        check_same(setup.fingerprint, language, setup.settings, known)
    recognizer = RecognitionEngine(language, setup.settings, known)
    if setup.memory:
        _limit_memory(setup.memory)
    return recognizer


def _limit_memory(more: int) -> None:
    """Limit this process to so much more memory than now, bytes; on Linux."""
    status = Path("/proc/self/status")
    if status.is_file():
        lines = dict(line.split(":", 1) for line in status.read_text().splitlines() if ":" in line)
        used = int(lines["VmData"].split()[0]) * 1024
        _, highest = resource.getrlimit(resource.RLIMIT_DATA)
        resource.setrlimit(resource.RLIMIT_DATA, (used + more, highest))
