"""Calls of several threads take turns."""

from __future__ import annotations

from threading import RLock

from voz.errors import RecognizerBusyError


class NonReentrantLock:
    """A lock that raises, instead of waiting for ever, in a signal handler of its own thread."""

    def __init__(self) -> None:
        self._lock = RLock()
        self._taken = False

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
