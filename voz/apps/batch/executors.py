"""Executes tasks: in worker processes of this machine, or in this process."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from typing import ClassVar, Protocol

from msgspec.structs import replace

from voz.apps.batch.tasks import BatchTask, TaskResult, WorkerSetup
from voz.apps.batch.worker import work
from voz.process.worker_pool import WorkerPool, worker_pool


class Executor(Protocol):
    """Executes tasks."""

    @property
    def size(self) -> int:
        """How many tasks at the same time; it may change."""

    @property
    def batch_bytes(self) -> int:
        """How much sound is handed out in one task, bytes."""

    def submit(self, task: BatchTask, limit: float | None) -> Future[TaskResult]:
        """Begin a task; a worker that takes longer than the limit, s, is ended.

        The future raises WorkerDied, TimeoutError, or VozError if the worker has no models.
        """


class InlineExecutor:
    """Does each task at once in this process, without a limit: quickest for a few recordings."""

    size = 1
    batch_bytes = 1

    def __init__(self, setup: WorkerSetup) -> None:
        # A memory limit would stay for this process, and for all that it starts.
        self._setup = replace(setup, memory=None)

    def submit(self, task: BatchTask, limit: float | None) -> Future[TaskResult]:
        """Do a task."""
        future: Future[TaskResult] = Future()
        future.set_result(work(self._setup, task))
        return future


@dataclass(frozen=True)
class ProcessExecutor:
    """Workers on this machine. One that dies takes only its task with it."""

    pool: WorkerPool
    setup: WorkerSetup
    size: int

    batch_bytes: ClassVar[int] = 2_000_000
    """A minute of sound, half a second of work."""

    def submit(self, task: BatchTask, limit: float | None) -> Future[TaskResult]:
        """Begin a task; see `Executor`."""
        return self.pool.schedule(work, args=(self.setup, task), timeout=limit)


@contextmanager
def process_executor(setup: WorkerSetup, size: int) -> Iterator[ProcessExecutor]:
    """Start workers for the length of a `with` block."""
    with worker_pool(size, loads_program=False) as pool:
        yield ProcessExecutor(pool, setup, size)
