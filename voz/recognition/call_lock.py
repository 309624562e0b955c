"""Calls of several threads take turns."""

from __future__ import annotations

from threading import RLock

from voz.errors import RecognizerBusyError


class NonReentrantLock:
    """A lock that raises in a thread that holds it already.

    That is a signal handler which interrupted the first call, and would wait for ever.
    """

    def __init__(self) -> None:
        self._lock = RLock()
        self._taken = False

    def __enter__(self) -> None:
        """Wait for other threads; raises RecognizerBusyError in the same one."""
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
