"""Decodes: in this process, in worker processes, or on a running cluster of dask.

Dask's scheduler gives a task whose worker died to another one, and gives it up after some deaths
(`distributed.scheduler.allowed-failures`, 3). Workers may come and go.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, InvalidStateError, TimeoutError
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from threading import Event, Thread
from typing import Any, ClassVar, Protocol, TypeAlias

from msgspec.structs import replace

from voz.apps.batch.outcomes import Outcome
from voz.apps.batch.worker import WorkerSetup, work
from voz.errors import ConfigError, VozError
from voz.extras import require
from voz.process.worker_pool import WorkerDied, WorkerPool, worker_pool

Outcomes: TypeAlias = tuple[Outcome, ...]
"""Of the recordings of a task, in their order."""


class Executor(Protocol):
    """Decodes some recordings after the other: a task."""

    @property
    def size(self) -> int:
        """How many tasks at the same time; it may change."""

    @property
    def batch_bytes(self) -> int:
        """How much sound is handed out in one task, bytes."""

    def submit(self, names: Sequence[str], limit: float | None) -> Future[Outcomes]:
        """Begin to decode recordings; a worker that takes longer than the limit, s, is ended.

        The future raises WorkerDied, TimeoutError, or VozError if the worker has no models.
        """


class InlineExecutor:
    """Does each task at once in this process, without a limit: quickest for a few recordings."""

    size = 1
    batch_bytes = 1

    def __init__(self, setup: WorkerSetup) -> None:
        # A memory limit would stay for this process, and for all that it starts.
        self._setup = replace(setup, memory=None)

    def submit(self, names: Sequence[str], limit: float | None) -> Future[Outcomes]:
        """Do a task."""
        future: Future[Outcomes] = Future()
        future.set_result(work(self._setup, names))
        return future


@dataclass(frozen=True)
class ProcessExecutor:
    """Workers on this machine. One that dies takes only its task with it."""

    pool: WorkerPool
    setup: WorkerSetup
    size: int

    batch_bytes: ClassVar[int] = 2_000_000
    """A minute of sound, half a second of work."""

    def submit(self, names: Sequence[str], limit: float | None) -> Future[Outcomes]:
        """Begin a task; see `Executor`."""
        return self.pool.schedule(work, args=(self.setup, names), timeout=limit)


@contextmanager
def process_executor(setup: WorkerSetup, size: int) -> Iterator[ProcessExecutor]:
    """Start workers for the length of a `with` block."""
    with worker_pool(size, loads_program=False) as pool:
        yield ProcessExecutor(pool, setup, size)


CONNECT_TIMEOUT = 30
"""For a cluster to answer, and to have its first worker, s."""

COUNT_INTERVAL = 5.0
"""How often the workers are counted, s."""

QUEUE_FACTOR = 3
"""A task may take so many times its limit, since it may wait for others."""

TIMEOUT_CHECK_INTERVAL = 1.0
"""How often time limits are checked, s."""


@dataclass(frozen=True)
class RunningTask:
    """A task on the cluster; `dask_future` is dask's future of it."""

    dask_future: Any
    future: Future[Outcomes]
    deadline: float


class DaskExecutor:
    """Workers of a cluster, however many there are at the time."""

    batch_bytes = 100_000_000
    """An hour of sound, half a minute of work: smaller tasks would load the scheduler."""

    def __init__(self, client: Any, setup: WorkerSetup) -> None:
        self._client, self._setup = client, setup
        self._counted, self._count = 0.0, 1
        self._limited: dict[str, RunningTask] = {}
        self._over = Event()
        self._patience = Thread(target=self._watch, name="voz-timeouts", daemon=True)
        self._patience.start()

    def close(self) -> None:
        """Stop the thread that watches time limits."""
        self._over.set()
        self._patience.join()

    @property
    def size(self) -> int:
        """How many workers there were lately; at least 1."""
        if time.monotonic() > self._counted + COUNT_INTERVAL:
            self._counted = time.monotonic()
            self._count = max(1, len(_workers(self._client)))
        return self._count

    def submit(self, names: Sequence[str], limit: float | None) -> Future[Outcomes]:
        """Begin a task; a worker that exceeds the limit, s, is restarted."""
        future: Future[Outcomes] = Future()
        dask_future = self._client.submit(work, self._setup, names, pure=False)
        if limit:
            deadline = time.monotonic() + limit * QUEUE_FACTOR
            self._limited[dask_future.key] = RunningTask(dask_future, future, deadline)

        def done(_: object) -> None:
            self._limited.pop(dask_future.key, None)
            _pass_on(dask_future, future)

        dask_future.add_done_callback(done)
        return future

    def _watch(self) -> None:
        while not self._over.wait(TIMEOUT_CHECK_INTERVAL):
            now = time.monotonic()
            for each in [each for each in list(self._limited.values()) if each.deadline < now]:
                self._limited.pop(each.dask_future.key, None)
                self._give_up(each)

    def _give_up(self, each: RunningTask) -> None:
        """Restart the worker that has a task."""
        with suppress(InvalidStateError):
            each.future.set_exception(TimeoutError())
        with suppress(Exception):  # it may have gone by itself
            busy = self._client.processing()
            at = [address for address, keys in busy.items() if each.dask_future.key in keys]
            each.dask_future.cancel()
            self._client.restart_workers(at)


@contextmanager
def dask_executor(address: str, setup: WorkerSetup) -> Iterator[DaskExecutor]:
    """Connect to a cluster by the address of its scheduler, for the length of a `with` block.

    Raises:
        ConfigError: dask is not installed, the cluster does not answer, or cannot be used.
    """
    require("dask", "distributed")
    from distributed import Client

    try:
        client = Client(  # type: ignore[no-untyped-call]
            address, timeout=CONNECT_TIMEOUT, set_as_default=False
        )
    except (OSError, asyncio.TimeoutError, ValueError, TypeError) as error:
        raise ConfigError(
            f"--dask {address}: no answer; is a dask scheduler running there?"
        ) from error
    with client:
        _check(client, address)
        pool = DaskExecutor(client, setup)
        try:
            yield pool
        finally:
            pool.close()


def _check(client: Any, address: str) -> None:
    """Refuse a cluster without workers, with threads in one, or with other versions.

    Each worker compares its voz, models and command list itself.
    """
    try:
        client.wait_for_workers(1, timeout=CONNECT_TIMEOUT)
    except (TimeoutError, asyncio.TimeoutError) as error:  # two kinds before Python 3.11
        raise ConfigError(
            f"--dask {address}: has no workers; start some with one thread"
        ) from error
    for name, worker in _workers(client).items():
        if worker["nthreads"] != 1:
            raise ConfigError(
                f"--dask {address}: the worker {name} has {worker['nthreads']} threads; start "
                "workers with --nthreads 1, and as many as there are cores"
            )
    versions = client.get_versions()
    ours = _versions(versions["client"])
    for name, worker in versions["workers"].items():
        if (theirs := _versions(worker)) != ours:
            raise ConfigError(
                f"--dask {address}: the worker {name} has {theirs}, not {ours}; install the same"
            )


def _versions(found: Any) -> str:
    python = ".".join(str(found["packages"]["python"]).split(".")[:2])
    return f"Python {python} and distributed {found['packages']['distributed']}"


def _workers(client: Any) -> dict[str, Any]:
    found: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    return found


def _pass_on(dask_future: Any, future: Future[Outcomes]) -> None:
    """Copy the outcome of dask's future to ours, unless that was given up."""
    from distributed import KilledWorker

    with suppress(InvalidStateError):
        if dask_future.status == "finished":
            future.set_result(dask_future.result())
            return
        error = dask_future.exception() if dask_future.status == "error" else None
        if isinstance(error, VozError):
            future.set_exception(error)
        elif error is None or isinstance(error, KilledWorker):
            future.set_exception(WorkerDied("with the workers that had it"))
        else:
            reason = f"{type(error).__name__}: {error}"
            future.set_exception(ConfigError(f"a worker cannot decode ({reason}); is voz there?"))
