"""Who does the tasks: processes of this machine, or this one itself."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future, TimeoutError
from contextlib import contextmanager
from typing import Any, Protocol

from msgspec.structs import replace

from voz.apps.batch.tasks import BatchTask, TaskResult, WorkerSetup
from voz.apps.batch.worker import work
from voz.process.worker_pool import WorkerPool, worker_pool


class TaskTimeout(Exception):
    """A task took longer than it may."""


class Executor(Protocol):
    """Who does tasks."""

    @property
    def size(self) -> int:
        """How many at the same time; it may change."""

    @property
    def batch(self) -> int:
        """How much sound is handed out at once, bytes: what comes back is a message."""

    def submit(self, task: BatchTask, limit: float | None) -> Any:
        """Begin a task, and give its future.

        Args:
            task: what to do.
            limit: how long it may take, s; None for as long as it likes.
        """

    def result(self, future: Any) -> TaskResult:
        """Give the result of a task that is done.

        Raises:
            WorkerDied: its worker ended.
            TooSlow: it was ended.
            VozError: the worker has no models to work with.
        """


class InlineExecutor:
    """Does each task at once: quickest for a few recordings, and nothing ends it but itself."""

    size = 1
    batch = 1

    def __init__(self, setup: WorkerSetup) -> None:
        # A limit on memory would be this process's for ever, and that of all it starts.
        self._setup = replace(setup, memory=None)

    def submit(self, task: BatchTask, limit: float | None) -> Future[TaskResult]:
        """Do a task; the limit is none."""
        future: Future[TaskResult] = Future()
        future.set_result(work(self._setup, task))
        return future

    def result(self, future: Future[TaskResult]) -> TaskResult:
        """Give what was done."""
        return future.result()


class ProcessExecutor:
    """Workers on this machine. One that dies takes its task with it and nothing else."""

    batch = 2_000_000
    """A minute of sound, half a second of work."""

    def __init__(self, pool: WorkerPool, setup: WorkerSetup, size: int) -> None:
        self.size = size
        self._pool, self._setup = pool, setup

    def submit(self, task: BatchTask, limit: float | None) -> Any:
        """Begin a task; its worker is killed if it takes longer than the limit."""
        return self._pool.schedule(work, args=(self._setup, task), timeout=limit)

    def result(self, future: Any) -> TaskResult:
        """Give the result of a task; raises what `Pool.result` does."""
        try:
            done: TaskResult = future.result()
        except TimeoutError as error:
            raise TaskTimeout from error
        return done


@contextmanager
def process_executor(setup: WorkerSetup, size: int) -> Iterator[ProcessExecutor]:
    """Have workers for the length of a `with` block, however it ends."""
    with worker_pool(size) as pool:
        yield ProcessExecutor(pool, setup, size)
