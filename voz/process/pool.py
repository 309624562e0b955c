"""Workers on this machine. One that dies takes what it does with it and nothing else."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, InvalidStateError
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from threading import Lock
from traceback import clear_frames
from typing import TYPE_CHECKING, Any

from voz.process.workers import begin_worker

if TYPE_CHECKING:
    from pebble import ProcessPool


class Died(Exception):
    """A worker ended in the midst of its work; its message says how."""


class WorkerPool:
    """Workers; others take their place, whichever of them end, and when."""

    def __init__(self, size: int) -> None:
        """Begin with none; they come with the first work."""
        self._size = size
        self._pool = _begun(size)
        self._under_way: set[Future[Any]] = set()
        self._lock = Lock()

    def schedule(
        self, function: Callable[..., Any], args: tuple[Any, ...], timeout: float | None = None
    ) -> Future[Any]:
        """Let a worker call a function.

        Args:
            function: of a module.
            args: what it is called with.
            timeout: how long it may take, s; a worker that takes longer is killed.

        Returns:
            Its future, which raises `Died` if the worker ended, TimeoutError if it took too long,
            else what the function raised.
        """
        ended: Future[Any] = Future()
        with self._lock:
            if not self._pool.active:
                self._begin_anew()
            self._under_way.add(ended)
            asked = self._pool.schedule(function, args=args, timeout=timeout)
        asked.add_done_callback(lambda done: self._pass_on(done, ended))
        return ended

    def close(self) -> None:
        """End all workers, whatever they do."""
        _end(self._pool)

    def _begin_anew(self) -> None:
        """Have other workers: pebble gives up if all of its own end while none has a task."""
        _end(self._pool)
        lost, self._under_way = self._under_way, set()
        self._pool = _begun(self._size)
        for future in lost:
            with suppress(InvalidStateError):
                future.set_exception(Died("with all the workers"))

    def _pass_on(self, done: Any, ended: Future[Any]) -> None:
        """Give on what became of a call, unless it was given up."""
        self._under_way.discard(ended)
        error = done.exception()
        with suppress(InvalidStateError):
            if error is None:
                ended.set_result(done.result())
            else:
                ended.set_exception(_told(error))


@contextmanager
def worker_pool(size: int) -> Iterator[WorkerPool]:
    """Have workers for the length of a `with` block; then all end, whatever they do."""
    pool = WorkerPool(size)
    try:
        yield pool
    finally:
        pool.close()


def _begun(size: int) -> ProcessPool:
    from pebble import ProcessPool

    # A fork would copy the threads of the progress bar, and with them locks that nobody opens.
    spawn = multiprocessing.get_context("spawn")
    return ProcessPool(size, initializer=begin_worker, initargs=(os.getpid(),), context=spawn)


def _end(pool: ProcessPool) -> None:
    pool.stop()  # type: ignore[no-untyped-call]
    pool.join()


def _told(error: BaseException) -> BaseException:
    """Say of a worker that ended how it did."""
    from pebble import ProcessExpired

    if isinstance(error, BrokenProcessPool):
        if error.__cause__:  # what was being sent hangs on it, of which Python 3.13 complains later
            clear_frames(error.__cause__.__traceback__)
        return Died("with all the workers")
    if not isinstance(error, ProcessExpired):
        return error
    code = error.exitcode
    return Died(f"killed by signal {-code}" if code and code < 0 else f"ended with {code}")


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
