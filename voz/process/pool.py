"""Workers on this machine. One that dies takes what it does with it and nothing else."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from voz.process.workers import begin_worker

if TYPE_CHECKING:
    from pebble import ProcessPool


class Died(Exception):
    """A worker ended in the midst of its work; its message says how."""


@contextmanager
def worker_pool(size: int) -> Iterator[ProcessPool]:
    """Have workers for the length of a `with` block; then all end, whatever they do."""
    from pebble import ProcessPool

    # A fork would copy the threads of the progress bar, and with them locks that nobody opens.
    spawn = multiprocessing.get_context("spawn")
    pool = ProcessPool(size, initializer=begin_worker, initargs=(os.getpid(),), context=spawn)
    try:
        yield pool
    finally:
        pool.stop()  # type: ignore[no-untyped-call]
        pool.join()


def result_of(future: Any) -> Any:
    """Give what a worker made; raises `Died` if it ended, else what it raised."""
    from pebble import ProcessExpired

    try:
        return future.result()
    except ProcessExpired as error:
        code = error.exitcode
        how = f"killed by signal {-code}" if code and code < 0 else f"ended with {code}"
        raise Died(how) from error


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
