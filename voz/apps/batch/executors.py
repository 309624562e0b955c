"""Executes tasks: in worker processes of this machine, or in this process."""

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
    """A task exceeded its time limit."""


class Executor(Protocol):
    """Executes tasks."""

    @property
    def size(self) -> int:
        """How many tasks at the same time; it may change."""

    @property
    def batch_bytes(self) -> int:
        """How much sound is handed out in one task, bytes."""

    def submit(self, task: BatchTask, limit: float | None) -> Any:
        """Begin a task and return its future; the limit is in s, None is none."""

    def result(self, future: Any) -> TaskResult:
        """Return the result of a task that is done.

        Raises:
            WorkerDied: its worker ended.
            TaskTimeout: it was ended.
            VozError: the worker has no models to work with.
        """


class InlineExecutor:
    """Does each task at once in this process: quickest for a few recordings."""

    size = 1
    batch_bytes = 1

    def __init__(self, setup: WorkerSetup) -> None:
        # A memory limit would stay for this process, and for all that it starts.
        self._setup = replace(setup, memory=None)

    def submit(self, task: BatchTask, limit: float | None) -> Future[TaskResult]:
        """Do a task, without a limit."""
        future: Future[TaskResult] = Future()
        future.set_result(work(self._setup, task))
        return future

    def result(self, future: Future[TaskResult]) -> TaskResult:
        """Return what was done."""
        return future.result()


class ProcessExecutor:
    """Workers on this machine. One that dies takes only its task with it."""

    batch_bytes = 2_000_000
    """A minute of sound, half a second of work."""

    def __init__(self, pool: WorkerPool, setup: WorkerSetup, size: int) -> None:
        self.size = size
        self._pool, self._setup = pool, setup

    def submit(self, task: BatchTask, limit: float | None) -> Any:
        """Begin a task; a worker that exceeds the limit, s, is killed."""
        return self._pool.schedule(work, args=(self._setup, task), timeout=limit)

    def result(self, future: Any) -> TaskResult:
        """Return the result of a task; raises as `Executor.result`."""
        try:
            done: TaskResult = future.result()
        except TimeoutError as error:
            raise TaskTimeout from error
        return done


@contextmanager
def process_executor(setup: WorkerSetup, size: int) -> Iterator[ProcessExecutor]:
    """Start workers for the length of a `with` block."""
    with worker_pool(size) as pool:
        yield ProcessExecutor(pool, setup, size)
