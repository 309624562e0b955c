"""Calls of several threads take turns, and a fork waits for its turn."""

from __future__ import annotations

import os
import time
from itertools import count
from threading import RLock
from weakref import WeakValueDictionary

from voz.errors import RecognizerBusyError

FORK_TURN = 0.001
"""For a thread that forks to take a lock before the one that released it, s."""


class NonReentrantLock:
    """A lock that raises, instead of waiting for ever, in a signal handler of its own thread.

    A child process has none of the threads that held it, and decoders as they were: so a fork waits
    until no other thread holds one.
    """

    def __init__(self) -> None:
        self._lock = RLock()
        self._taken = False
        with _forking:
            _locks[next(_numbers)] = self

    def __enter__(self) -> None:
        self._lock.acquire()
        if self._taken:
            self._lock.release()
            raise RecognizerBusyError(
                "a signal handler calls the recognizer in the midst of another call; let it set a "
                "flag, and call the recognizer where that is looked at"
            )
        self._taken = True

    def __exit__(self, *_: object) -> None:
        self._taken = False
        self._lock.release()
        if _held:
            time.sleep(FORK_TURN)  # else this thread mostly has it again first

    def hold_for_fork(self) -> None:
        """Wait until no other thread has it; `release_after_fork` follows."""
        self._lock.acquire()

    def release_after_fork(self) -> None:
        """Let other threads have it again."""
        self._lock.release()


_forking = RLock()
_locks: WeakValueDictionary[int, NonReentrantLock] = WeakValueDictionary()
_numbers = count()
_held: list[list[NonReentrantLock]] = []
"""For each fork under way; a signal handler may fork amid another one."""


def _before_fork() -> None:
    _forking.acquire()
    _held.append([])
    # The newest first: whoever has that of a stream waits for that of its recognizer, an older one.
    for _, lock in sorted(_locks.items(), reverse=True):
        lock.hold_for_fork()
        _held[-1].append(lock)


def _after_fork() -> None:
    for lock in _held.pop():
        lock.release_after_fork()
    _forking.release()


os.register_at_fork(before=_before_fork, after_in_parent=_after_fork, after_in_child=_after_fork)
