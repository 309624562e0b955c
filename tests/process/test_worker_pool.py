"""Workers on this machine: whichever of them end, and when, others go on."""

from __future__ import annotations

import os
import signal
import sys
import time
from concurrent.futures import TimeoutError
from pickle import PicklingError
from typing import Any

import pytest
from programs import PATIENCE, is_alive

from voz.process.worker_pool import WorkerDied, WorkerPool, worker_pool

pytestmark = pytest.mark.slow


def called(pool: WorkerPool, function: Any, *args: Any) -> Any:
    """What a call gives; as of any work that a worker may have died beside, it is tried again."""
    until = time.monotonic() + PATIENCE
    while True:
        try:
            return pool.schedule(function, args).result(PATIENCE)
        except WorkerDied:
            assert time.monotonic() < until


def test_all_that_end_with_nothing_to_do_have_successors() -> None:
    with worker_pool(1) as pool:
        for _ in range(3):
            os.kill(before := called(pool, os.getpid), signal.SIGKILL)
            assert called(pool, os.getpid) != before
            os.kill(before := called(pool, os.getpid), signal.SIGKILL)
            while is_alive(before):
                time.sleep(0.01)
            assert pool.schedule(os.getpid, ()).result(PATIENCE) != before  # it had no task to lose


def test_what_a_worker_ends_in_is_told_of() -> None:
    with worker_pool(1) as pool:
        with pytest.raises(WorkerDied, match="ended with 3"):
            pool.schedule(os._exit, (3,)).result(PATIENCE)
        with pytest.raises(TimeoutError):
            pool.schedule(time.sleep, (60.0,), timeout=0.1).result(PATIENCE)
        with pytest.raises(ZeroDivisionError):
            pool.schedule(divmod, (1, 0)).result(PATIENCE)
        assert called(pool, abs, -1) == 1


def test_what_cannot_be_sent_to_or_from_a_worker_leaves_it_alive() -> None:
    with worker_pool(1) as pool:
        worker = called(pool, os.getpid)
        for function, args in (abs, (lambda: None,)), (sys._getframe, ()):
            with pytest.raises((PicklingError, TypeError, AttributeError)):
                pool.schedule(function, args).result(PATIENCE)
        assert called(pool, os.getpid) == worker


def test_tasks_are_done_side_by_side_and_end_with_the_pool() -> None:
    with worker_pool(2) as pool:
        first, second = (pool.schedule(time.sleep, (PATIENCE * 2,)) for _ in range(2))
        third = pool.schedule(os.getpid, ())
        with pytest.raises(TimeoutError):
            third.result(0.5)
    for future in first, second, third:
        with pytest.raises(WorkerDied):
            future.result(0.0)
