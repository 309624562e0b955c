"""A cluster of dask.distributed's that is there already does the tasks.

Its scheduler gives a task whose worker went to another one, and gives it back after some deaths
(`distributed.scheduler.allowed-failures`, 3); its recordings are then tried alone, so that
one that workers die of costs no other. Workers may come and go meanwhile.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from concurrent.futures import Future, InvalidStateError
from contextlib import contextmanager, suppress
from threading import Event, Lock, Thread
from typing import Any, NamedTuple

from voz.apps.batch.executors import TaskTimeout
from voz.apps.batch.tasks import BatchTask, TaskResult, WorkerSetup
from voz.apps.batch.worker import work
from voz.errors import ConfigError, VozError
from voz.extras import how_to_install
from voz.process.worker_pool import WorkerDied

CONNECT_TIMEOUT = 30
"""How long a cluster may take to answer, and to have its first worker, s."""

COUNT_INTERVAL = 5.0
"""How often it is looked how many workers there are, s."""

QUEUE_FACTOR = 3
"""Times its limit a task may take until it is given up: it may have to wait for others."""

TIMEOUT_CHECK_INTERVAL = 1.0
"""How often it is looked what takes too long, s."""

_ONE_AT_A_TIME = Lock()


class RunningTask(NamedTuple):
    """A task that a cluster has: dask's future of it, ours, and when it is given up, s."""

    asked: Any
    ended: Future[TaskResult]
    due: float


class DaskExecutor:
    """Workers of a cluster, however many there are at the time."""

    batch = 100_000_000
    """An hour of sound, half a minute of work: of more tasks the scheduler would have much to do.
    """

    def __init__(self, client: Any, setup: WorkerSetup) -> None:
        self._client, self._setup = client, setup
        self._counted, self._count = 0.0, 1
        self._limited: dict[str, RunningTask] = {}
        self._over = Event()
        self._patience = Thread(target=self._watch, name="voz-patience", daemon=True)
        self._patience.start()

    def close(self) -> None:
        """Look no more for what takes too long."""
        self._over.set()
        self._patience.join()

    @property
    def size(self) -> int:
        """How many workers there were lately; one at least."""
        if time.monotonic() > self._counted + COUNT_INTERVAL:
            self._counted = time.monotonic()
            self._count = max(1, len(_workers(self._client)))
        return self._count

    def submit(self, task: BatchTask, limit: float | None) -> Future[TaskResult]:
        """Begin a task; what takes longer than the limit costs its worker."""
        ended: Future[TaskResult] = Future()
        asked = self._client.submit(work_exclusively, self._setup, task, pure=False)
        if limit:
            due = time.monotonic() + limit * QUEUE_FACTOR
            self._limited[asked.key] = RunningTask(asked, ended, due)

        def done(_: object) -> None:
            self._limited.pop(asked.key, None)
            _pass_on(asked, ended)

        asked.add_done_callback(done)
        return ended

    def result(self, future: Future[TaskResult]) -> TaskResult:
        """Give the result of a task; raises what `Pool.result` does."""
        return future.result()

    def _watch(self) -> None:
        while not self._over.wait(TIMEOUT_CHECK_INTERVAL):
            now = time.monotonic()
            for each in [each for each in list(self._limited.values()) if each.due < now]:
                self._limited.pop(each.asked.key, None)
                self._give_up(each)

    def _give_up(self, each: RunningTask) -> None:
        """Restart the worker that does not come back from a task."""
        with suppress(InvalidStateError):
            each.ended.set_exception(TaskTimeout())
        with suppress(Exception):  # it may have gone by itself
            busy = self._client.processing()
            at = [address for address, keys in busy.items() if each.asked.key in keys]
            each.asked.cancel()
            self._client.restart_workers(at)


@contextmanager
def dask_executor(address: str, setup: WorkerSetup) -> Iterator[DaskExecutor]:
    """Use a cluster for the length of a `with` block.

    Args:
        address: of its scheduler, as `tcp://10.0.0.1:8786`.
        setup: what workers are told.

    Raises:
        ConfigError: dask is not installed, the cluster does not answer, or cannot be used.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise ConfigError(f"dask is not installed; {how_to_install('dask')}") from error
    try:
        client = Client(  # type: ignore[no-untyped-call]
            address, timeout=CONNECT_TIMEOUT, set_as_default=False
        )
    except (OSError, asyncio.TimeoutError, ValueError, TypeError) as error:
        raise ConfigError(f"--dask {address}: nothing answers there; is a scheduler up?") from error
    with client:
        _check(client, address)
        pool = DaskExecutor(client, setup)
        try:
            yield pool
        finally:
            pool.close()


def work_exclusively(setup: WorkerSetup, task: BatchTask) -> TaskResult:
    """Do a task, one at a time: a recognizer is for one thread."""
    with _ONE_AT_A_TIME:
        return work(setup, task)


def _check(client: Any, address: str) -> None:
    """Refuse a cluster without workers, with others than this program can talk to, or with threads.

    Whether they have the same voz, models and list each worker finds out itself.
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


def _pass_on(asked: Any, ended: Future[TaskResult]) -> None:
    """Give on what became of a task, unless it was given up."""
    from distributed import KilledWorker

    with suppress(InvalidStateError):
        if asked.status == "finished":
            ended.set_result(asked.result())
            return
        error = asked.exception() if asked.status == "error" else None
        if isinstance(error, VozError):
            ended.set_exception(error)
        elif error is None or isinstance(error, KilledWorker):
            ended.set_exception(WorkerDied("with the workers that had it"))
        else:
            reason = f"{type(error).__name__}: {error}"
            ended.set_exception(ConfigError(f"a worker cannot decode ({reason}); is voz there?"))
