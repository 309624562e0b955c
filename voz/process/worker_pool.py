"""Worker processes on this computer; one that dies loses its own task and no other."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Future, InvalidStateError
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from threading import Lock
from traceback import clear_frames
from types import ModuleType
from typing import TYPE_CHECKING, Any

from voz.process.setup import set_up
from voz.process.standard_streams import quiet_libraries

if TYPE_CHECKING:
    from pebble import ProcessPool

PR_SET_PDEATHSIG = 1
"""The number of this setting in Linux's `prctl.h`."""

_UNTIL_EXIT = ExitStack()
_STARTING = Lock()


class WorkerDied(Exception):
    """A worker process ended during its task; the message says how."""


class WorkerPool:
    """A pool of worker processes; those that end are replaced."""

    def __init__(self, size: int, loads_program: bool = True) -> None:
        """Prepare a pool; the processes start with the first task."""
        self._size = size
        self._context = _context(loads_program)
        self._pool = _start_pool(size, self._context)
        self._under_way: set[Future[Any]] = set()
        self._lock = Lock()

    def schedule(
        self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float | None = None
    ) -> Future[Any]:
        """Let a worker call a function of a module; one that takes `timeout` s is killed.

        Returns:
            The future; it raises `WorkerDied`, TimeoutError, or what the function raised.
        """
        ended: Future[Any] = Future()
        with self._lock:
            if not self._pool.active:
                self._restart()
            self._under_way.add(ended)
            asked = self._pool.schedule(function, args=args, timeout=timeout)
        asked.add_done_callback(lambda done: self._pass_on(done, ended))
        return ended

    def close(self) -> None:
        """Kill all workers."""
        _stop_pool(self._pool)

    def _restart(self) -> None:
        """Start new workers: pebble gives up if all its workers end while none has a task."""
        _stop_pool(self._pool)
        lost, self._under_way = self._under_way, set()
        self._pool = _start_pool(self._size, self._context)
        for future in lost:
            with suppress(InvalidStateError):
                future.set_exception(WorkerDied("with all the workers"))

    def _pass_on(self, done: Any, ended: Future[Any]) -> None:
        self._under_way.discard(ended)
        error = done.exception()
        with suppress(InvalidStateError):
            if error is None:
                ended.set_result(done.result())
            else:
                ended.set_exception(_death_of(error))


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
        with _STARTING:
            program = sys.modules["__main__"]
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


def _start_pool(size: int, context: SpawnContext) -> ProcessPool:
    from pebble import ProcessPool

    parent = (os.getpid(),)
    return ProcessPool(size, initializer=begin_worker, initargs=parent, context=context)


def _stop_pool(pool: ProcessPool) -> None:
    pool.stop()  # type: ignore[no-untyped-call]
    pool.join()


def _death_of(error: BaseException) -> BaseException:
    from pebble import ProcessExpired

    if isinstance(error, BrokenProcessPool):
        if error.__cause__:  # it holds the message, of which Python 3.13 complains later
            clear_frames(error.__cause__.__traceback__)
        return WorkerDied("with all the workers")
    if not isinstance(error, ProcessExpired):
        return error
    code = error.exitcode
    return WorkerDied(f"killed by signal {-code}" if code and code < 0 else f"ended with {code}")


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
