"""Worker processes on this computer; one that dies loses its own task and no other."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Future, TimeoutError
from contextlib import ExitStack, contextmanager
from multiprocessing.connection import wait
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.pool import ExceptionWithTraceback  # type: ignore[attr-defined]
from multiprocessing.process import BaseProcess
from queue import SimpleQueue
from threading import Lock, Thread
from types import ModuleType
from typing import Any, NamedTuple

from voz.process.setup import set_up
from voz.process.standard_streams import quiet_libraries

PR_SET_PDEATHSIG = 1
"""The number of this setting in Linux's `prctl.h`."""

_UNTIL_EXIT = ExitStack()
_PROCESSES = Lock()
"""multiprocessing asks after all its processes when it starts one: two threads would collide."""


class WorkerDied(Exception):
    """A worker process ended during its task; the message says how."""


class _Task(NamedTuple):
    function: Callable[..., Any]
    args: tuple[Any, ...]
    timeout: float | None
    future: Future[Any]


class _Worker(NamedTuple):
    process: BaseProcess
    pipe: Any  # the only one to it: no lock of a dead worker can keep another from its own


class WorkerPool:
    """A pool of worker processes; those that end are replaced."""

    def __init__(self, size: int, loads_program: bool = True) -> None:
        """Prepare a pool; the processes start with the first tasks."""
        self._context = _context(loads_program)
        self._tasks: SimpleQueue[_Task | None] = SimpleQueue()
        self._workers: set[_Worker] = set()
        self._closed = False
        self._threads = [
            Thread(target=self._serve, name="voz-worker", daemon=True) for _ in range(size)
        ]
        for thread in self._threads:
            thread.start()

    def schedule(
        self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float | None = None
    ) -> Future[Any]:
        """Let a worker call a function of a module; one that takes `timeout` s is killed.

        Returns:
            The future; it raises `WorkerDied`, TimeoutError, or what the function raised.
        """
        task = _Task(function, args, timeout, Future())
        self._tasks.put(task)
        return task.future

    def close(self) -> None:
        """Kill all workers; tasks that are not done end with `WorkerDied`."""
        with _PROCESSES:
            self._closed = True
            for worker in self._workers:
                worker.process.kill()
        for _ in self._threads:
            self._tasks.put(None)
        for thread in self._threads:
            thread.join()

    def _serve(self) -> None:
        """Hand tasks to a worker, one at a time, until the pool is closed."""
        worker: _Worker | None = None
        while task := self._tasks.get():
            try:
                if worker and worker.pipe.poll():  # only its end can be read there
                    self._end(worker)
                    worker = None
                worker = worker or self._start()
                task.future.set_result(_answer(worker, task))
            except BaseException as error:
                task.future.set_exception(error)
        if worker:
            self._end(worker)

    def _start(self) -> _Worker:
        with _PROCESSES:
            if self._closed:
                raise WorkerDied("with all the workers")
            try:
                ours, theirs = self._context.Pipe()
                process = self._context.Process(target=_work, args=(theirs, os.getpid()))
                process.start()
            except OSError as error:
                raise WorkerDied(f"could not be started: {error}") from error
            self._workers.add(worker := _Worker(process, ours))
        theirs.close()  # else the end of the worker would not close it
        return worker

    def _end(self, worker: _Worker) -> None:
        worker.pipe.close()
        with _PROCESSES:
            self._workers.discard(worker)
            worker.process.join()


def _answer(worker: _Worker, task: _Task) -> Any:
    """What a worker answers to a task; raises `WorkerDied`, TimeoutError, or the task's error."""
    try:
        worker.pipe.send((task.function, task.args))
        answer = worker.pipe.recv()
        if answer is None:  # it has begun; what it had to load for it is not counted
            if not wait([worker.pipe], task.timeout):
                worker.process.kill()
                raise TimeoutError(f"{_end_of(worker.process)} after {task.timeout} s")
            answer = worker.pipe.recv()
    except (EOFError, ConnectionError):
        raise WorkerDied(_end_of(worker.process)) from None
    is_done, value = answer
    if is_done:
        return value
    raise value


def _end_of(process: BaseProcess) -> str:
    with _PROCESSES:
        process.join()
        code = process.exitcode
    return f"killed by signal {-code}" if code and code < 0 else f"ended with {code}"


def _work(pipe: Any, parent: int) -> None:
    """Be a worker: do tasks until the pipe is closed."""
    begin_worker(parent)
    while True:
        try:
            task = pipe.recv_bytes()
        except EOFError:
            return
        try:
            function, args = pickle.loads(task)
            pipe.send(None)
            pipe.send((True, function(*args)))
        except Exception as error:
            pipe.send((False, ExceptionWithTraceback(error, error.__traceback__)))


@contextmanager
def worker_pool(size: int, loads_program: bool = True) -> Iterator[WorkerPool]:
    """Make a pool for a `with` block; its workers are killed at the end.

    Args:
        size: how many workers.
        loads_program: whether workers import the user's program, whose functions they may call;
            without `if __name__ == "__main__"` it would start workers of its own.
    """
    pool = WorkerPool(size, loads_program)
    try:
        yield pool
    finally:
        pool.close()


class _BareProcess(SpawnProcess):
    """Does not import the user's program."""

    @staticmethod
    def _Popen(process: BaseProcess) -> Any:  # noqa: N802
        program = sys.modules["__main__"]  # the one who starts it holds _PROCESSES
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            return SpawnProcess._Popen(process)
        finally:
            sys.modules["__main__"] = program


class _BareContext(SpawnContext):
    Process = _BareProcess


def _context(loads_program: bool) -> SpawnContext:
    # A fork would copy the locks of the progress bar's thread, locked forever.
    return SpawnContext() if loads_program else _BareContext()


def cores() -> int:
    """The number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def begin_worker(parent: int) -> None:
    """Set up a worker process, which ends with `parent` and leaves Ctrl-C to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    set_up()
    _end_with(parent)
    _UNTIL_EXIT.enter_context(quiet_libraries())


def _end_with(parent: int) -> None:
    import ctypes

    libc = ctypes.CDLL(None)
    if hasattr(libc, "prctl"):  # on other systems a worker ends when its pipe is closed
        libc.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)
