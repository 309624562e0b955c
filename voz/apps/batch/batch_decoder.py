"""Decodes many recordings: in this process, by workers on this machine, or on a cluster."""

from __future__ import annotations

import logging
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from msgspec.structs import replace

from voz.api.load import open_language
from voz.apps.batch.executors import (
    Executor,
    InlineExecutor,
    ProcessExecutor,
    dask_executor,
    process_executor,
)
from voz.apps.batch.fingerprint import header_for
from voz.apps.batch.inputs import find_inputs
from voz.apps.batch.outcomes import ErrorRow, Outcome, UtteranceRow, utterance_of
from voz.apps.batch.output import in_input_order
from voz.apps.batch.scheduler import Finished, Scheduler, size_of
from voz.apps.batch.worker import WorkerSetup
from voz.events import Utterance
from voz.process.worker_pool import cores
from voz.recognition.interpreter import Details
from voz.recognition.profiles import load_profile
from voz.records import check_iterable, check_path, check_type
from voz.settings import Recognition

_log = logging.getLogger("voz")

MOST_INLINE_RECORDINGS = 2
"""So few short ones are decoded before another process has started."""


@dataclass(frozen=True)
class BatchDecoder:
    """How recordings are decoded."""

    setup: WorkerSetup
    jobs: int | None = None  # processes; None for one on each core
    limit: float | None = None  # for a recording, s; None for its length and a minute
    isolated: bool = False  # whether a recording must not end this process, however few there are
    cluster: str | None = None  # address of a dask scheduler; None for this machine

    def decode(
        self, names: Sequence[str], numbers: Sequence[int]
    ) -> Generator[Finished, None, None]:
        """Decode the recordings with these indexes; yields the outcomes as they come.

        Raises:
            VozError: the models cannot be loaded, or the cluster cannot be reached.
        """
        with self._executor([names[number] for number in numbers]) as executor:
            yield from Scheduler(executor, names, numbers, self.limit).run()

    def _executor(self, names: Sequence[str]) -> AbstractContextManager[Executor]:
        if self.cluster:
            # dask limits the memory of its workers itself.
            setup = replace(self.setup, memory=None, base=str(Path.cwd()))
            return dask_executor(self.cluster, setup)
        jobs = self.jobs or cores()
        if not self.isolated and self.limit is None and (jobs == 1 or _is_little(names)):
            return nullcontext(InlineExecutor(self.setup))
        return process_executor(self.setup, jobs)


def _is_little(names: Sequence[str]) -> bool:
    """Whether other processes would not be quicker: a recording is decoded by one alone."""
    is_one_task = sum(map(size_of, names)) <= ProcessExecutor.batch_bytes
    return len(names) == 1 or (len(names) <= MOST_INLINE_RECORDINGS and is_one_task)


Recordings = str | PathLike[str] | Iterable[str | PathLike[str]]


@dataclass(frozen=True)
class Decoded:
    """A recording that was decoded.

    Attributes:
        file: its path or address.
        utterances: what is said in it, by time.
        seconds: how much of it was heard, s.
        error: why it could not be read to its end; None if it was.
    """

    file: str
    utterances: list[Utterance]
    seconds: float
    error: str | None = None


def decode_many(
    recordings: Recordings,
    commands: str | PathLike[str] | Iterable[str] | None = None,
    settings: Recognition | None = None,
    profile: str | None = None,
    *,
    jobs: int | None = None,
    words: bool = False,
    best: int = 0,
) -> Iterator[Decoded]:
    """Decode recordings on all cores, each as if it were alone.

    One that cannot be read, or that a library crashes on, costs no other.

    Args:
        recordings: files, folders, manifests (.tsv) and addresses, one or several.
        commands: as for `load`.
        settings: as for `load`.
        profile: as for `load`.
        jobs: processes; None for one on each core, and for one, or two short ones, none.
        words: as for `Recognizer.decode`.
        best: as for `Recognizer.decode`.

    Yields:
        The recordings in the order in which they are named, each as soon as it is decoded.

    Raises:
        CommandsError: the list cannot be used.
        LanguageError: the language files cannot be used.
        ConfigError: as for `load` and `Recognizer.decode`, or a folder or a manifest holds no
            recording.
    """
    one = isinstance(recordings, str | PathLike)
    given = [recordings] if one else check_iterable(recordings, "recordings")
    settings = Recognition() if settings is None else settings
    check_type(Recognition, settings, "settings")
    check_type((str, type(None)), profile, "profile")
    check_type((int, type(None)), jobs, "jobs")
    inputs = find_inputs([check_path(each, "recordings") for each in given], None, ())
    if inputs.left_out_warning:
        _log.warning(inputs.left_out_warning)
    details = Details(words, best)
    known = load_profile(profile) if profile else None
    with open_language(commands) as language:
        header = header_for(language, settings, known)
        folder = str(language.folder.resolve())
        setup = WorkerSetup(
            folder, settings, profile, fingerprint=header.fingerprint, details=details
        )
        numbers = range(len(inputs.names))
        with closing(BatchDecoder(setup, jobs).decode(inputs.names, numbers)) as finished:
            for outcome in in_input_order(finished):
                for warning in outcome.warnings:
                    _log.warning(warning)
                yield _decoded(outcome)


def _decoded(outcome: Outcome) -> Decoded:
    last = outcome.rows[-1]
    heard = [utterance_of(row) for row in outcome.rows if isinstance(row, UtteranceRow)]
    error = last.error if isinstance(last, ErrorRow) else None
    return Decoded(last.file, heard, outcome.seconds, error)
