"""The tasks of a worker: the models are loaded once, and a bad recording is only a row."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TypeAlias

import msgspec
from msgspec.structs import replace

from voz.apps.batch.decoding import decode_recording
from voz.apps.batch.fingerprint import check_same
from voz.apps.batch.locations import LocalRecording, local_recording, shown_name
from voz.apps.batch.long_recordings import (
    CutPlan,
    DecodedPart,
    RecordingPart,
    decode_part,
    is_long,
    plan_cuts,
)
from voz.apps.batch.outcomes import ErrorRow, Outcome, Row, failed_outcome
from voz.apps.batch.stamps import stamp_of, with_checksum
from voz.errors import AudioError, VozError
from voz.files import shown_path
from voz.language.language_files import LanguageFiles
from voz.recognition.engine import RecognitionEngine
from voz.recognition.interpreter import NO_DETAILS, Details
from voz.recognition.speaker.profiles import load_profile
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


class DecodeTask(msgspec.Struct, frozen=True):
    """Recordings to be decoded."""

    names: tuple[str, ...]  # paths and addresses
    cut: bool = False  # whether long ones come back as None, to be cut


class CutTask(msgspec.Struct, frozen=True):
    """Find where a long recording can be cut."""

    name: str


class PartTask(msgspec.Struct, frozen=True):
    """Decode a part of a long recording."""

    name: str
    part: RecordingPart


BatchTask: TypeAlias = DecodeTask | CutTask | PartTask

TaskResult: TypeAlias = tuple[Outcome | None, ...] | CutPlan | DecodedPart | None
"""By the task: the outcomes of its files, None for one to be cut; the plan of a cut, None if there
is none; or the part that was decoded."""


BYTES_PER_MEGABYTE = 1_000_000


def work(setup: WorkerSetup, task: BatchTask) -> TaskResult:
    """Do a task.

    Raises:
        AudioError: it is of one recording, which cannot be decoded.
        VozError: the models cannot be loaded, or differ from those of the output.
    """
    recognizer = _loaded(setup)
    if isinstance(task, DecodeTask):
        return tuple(_decoded(recognizer, name, task.cut, setup) for name in task.names)
    # Made before it is read: if it changes meanwhile, the next run finds another stamp.
    stamp = stamp_of(task.name, setup.base) if isinstance(task, CutTask) else None
    with (
        _errors_as_audio_error(task.name, setup.memory),
        local_recording(task.name, setup.base) as found,
    ):
        if isinstance(task, CutTask):
            stamp = stamp and with_checksum(stamp, found.path)
            plan = plan_cuts(found.path)
            return plan and replace(plan, stamp=stamp)
        done = decode_part(recognizer, found.path, task.part, found.name, setup.details)
        return replace(done, rows=_named(done.rows, found))


def _decoded(
    recognizer: RecognitionEngine, name: str, cut: bool, setup: WorkerSetup
) -> Outcome | None:
    """Decode a recording, with any error as its last row; None if it should be cut."""
    stamp = stamp_of(name, setup.base)
    try:
        with _errors_as_audio_error(name, setup.memory), local_recording(name, setup.base) as found:
            if cut and not setup.simulation and is_long(found.path):
                return None
            stamp = stamp and with_checksum(stamp, found.path)
            outcome = _heard(recognizer, found, setup)
            return replace(outcome, rows=_named(outcome.rows, found), stamp=stamp)
    except AudioError as error:
        return failed_outcome(shown_name(name), str(error), stamp)


def _heard(recognizer: RecognitionEngine, found: LocalRecording, setup: WorkerSetup) -> Outcome:
    if setup.simulation is None:
        return decode_recording(recognizer, found.path, found.name, setup.details)
    from voz.apps.batch.simulated_run import simulate_recording

    return simulate_recording(recognizer, found, setup.simulation, setup.details)


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
    error = last.error.replace(shown_path(found.path), found.name)
    return (*rows[:-1], ErrorRow(last.file, error))


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
