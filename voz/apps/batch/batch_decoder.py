"""Decodes many recordings: in this process, by workers on this machine, or on a cluster.

A scheduler hands them out to workers, and isolates those that workers die of.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Generator, Iterable, Iterator, Sequence
from concurrent.futures import Future, TimeoutError
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple

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
from voz.apps.batch.locations import is_remote, shown_name
from voz.apps.batch.outcomes import ErrorRow, Outcome, UtteranceRow, failed_outcome, utterance_of
from voz.apps.batch.stamps import stamp_of
from voz.apps.batch.worker import WorkerSetup
from voz.events import Utterance
from voz.process.worker_pool import WorkerDied, cores
from voz.recognition.interpreter import Details
from voz.recognition.profiles import load_profile
from voz.records import check_iterable, check_path, check_type
from voz.settings import Recognition

_log = logging.getLogger("voz")

MOST_FILES_PER_TASK = 1000
"""Most recordings in a task, however small they are."""

REMOTE_SIZE_BYTES = 500_000
"""Assumed size of a recording at an address, bytes."""

TASKS_PER_WORKER = 4
"""The recordings left are split into so many tasks a worker, so that the last ones are small."""

QUEUED_PER_WORKER = 2
"""Tasks that each worker has at a time, so that it never waits for the next one."""

LEAST_BYTES_PER_SECOND = 4000
"""Lowest rate of a compressed recording, from which the longest length of a file follows."""


class Finished(NamedTuple):
    """A recording that is decoded: its index in the input, and the outcome."""

    number: int
    outcome: Outcome


@dataclass(frozen=True)
class ScheduledTask:
    """Recordings that a worker decodes, by their indexes."""

    numbers: tuple[int, ...]
    again: bool = False  # whether a worker died of it already


class Scheduler:
    """Decodes recordings by an executor; made once for each input."""

    def __init__(
        self,
        executor: Executor,
        names: Sequence[str],
        numbers: Sequence[int],
        limit: float | None = None,
    ) -> None:
        """Begin with nothing done.

        `numbers` are the indexes of the names to be decoded. The limit is for a recording, s; None
        is its length and a minute.
        """
        self._executor, self._names, self._limit = executor, names, limit
        self._left = deque(numbers)
        self._first: deque[ScheduledTask] = deque()  # before all others
        self._alone: deque[ScheduledTask] = deque()  # with nothing else running
        self._ended: SimpleQueue[tuple[ScheduledTask, Future[tuple[Outcome, ...]]]] = SimpleQueue()

    def run(self) -> Iterator[Finished]:
        """Decode; yields the outcomes as they come."""
        under_way = 0
        while True:
            while under_way < QUEUED_PER_WORKER * self._executor.size and (task := self._next()):
                self._submit(task)
                under_way += 1
            if not under_way:
                if not self._alone:
                    return
                # Else other tasks would be blamed for the death of their workers, too.
                self._submit(self._alone.popleft())
                under_way = 1
            task, future = self._ended.get()
            under_way -= 1
            yield from self._take(task, future)

    def _next(self) -> ScheduledTask | None:
        """The next task: a suspicious recording, or some new ones."""
        if self._first:
            return self._first.popleft()
        most = max(
            1, min(MOST_FILES_PER_TASK, len(self._left) // (TASKS_PER_WORKER * self._executor.size))
        )
        numbers: list[int] = []
        size = 0
        while self._left and len(numbers) < most and size < self._executor.batch_bytes:
            numbers.append(self._left.popleft())
            size += size_of(self._names[numbers[-1]])
        return ScheduledTask(tuple(numbers)) if numbers else None

    def _submit(self, task: ScheduledTask) -> None:
        names = [self._names[number] for number in task.numbers]
        future = self._executor.submit(names, self._limit_for(names))
        future.add_done_callback(lambda done: self._ended.put((task, done)))

    def _limit_for(self, names: Sequence[str]) -> float:
        if self._limit is not None:
            return self._limit
        return 60.0 + sum(map(size_of, names)) / LEAST_BYTES_PER_SECOND

    def _take(self, task: ScheduledTask, future: Future[tuple[Outcome, ...]]) -> Iterator[Finished]:
        """Handle a task that has ended, one way or the other."""
        try:
            outcomes = future.result()
        except TimeoutError:
            yield from self._suspect(task, "takes too long; raise --time-limit", again=False)
        except WorkerDied as death:
            said = f"made its worker end twice ({death}); leave it out, or raise --memory-limit"
            yield from self._suspect(task, said, again=not task.again)
        else:
            yield from map(Finished, task.numbers, outcomes)

    def _suspect(self, task: ScheduledTask, said: str, again: bool) -> Iterator[Finished]:
        """Retry what a worker died of: each recording alone, then with nothing else running."""
        if len(task.numbers) > 1:
            self._first.extend(ScheduledTask((number,)) for number in task.numbers)
        elif again:
            self._alone.append(ScheduledTask(task.numbers, again=True))
        else:
            (number,) = task.numbers
            name = self._names[number]
            error = f"{shown_name(name)}: {said}"
            yield Finished(number, failed_outcome(shown_name(name), error, stamp_of(name)))


def size_of(name: str) -> int:
    """The size of a recording, bytes; assumed of one at an address, 0 if it is missing."""
    if is_remote(name):
        return REMOTE_SIZE_BYTES
    try:
        return Path(name).stat().st_size
    except (OSError, ValueError):
        return 0


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


def in_input_order(known: Iterator[Finished]) -> Iterator[Outcome]:
    """Put outcomes into the order of the input; early ones wait."""
    early: dict[int, Outcome] = {}
    following = 0
    for number, outcome in known:
        early[number] = outcome
        while following in early:
            yield early.pop(following)
            following += 1


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
