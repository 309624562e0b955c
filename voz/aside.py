"""Lets what writes events down do so on a thread of its own: a robot must not wait for a reader."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager

from voz.events import Event, Receiver, Warning

MOST_WAITING = 6000
"""Events that may wait for a slow disk or reader: those of ten minutes."""

CLOSING_TIME = 3.0
"""For what waits to be written when the run is over, s; some readers never read it."""


class Aside:
    """Hands events to a receiver that may be slow, without waiting for it.

    Use it in a `with` block: the receiver is opened at its beginning, and gets what waits and is
    closed at its end. What it raises is raised by the next event, or by the end of the block.
    """

    def __init__(
        self, name: str, opening: AbstractContextManager[Receiver], take: Callable[[Warning], None]
    ) -> None:
        """Prepare to hand events on.

        Args:
            name: what is written, for messages.
            opening: gives what takes the events; it is entered and left on the other thread.
            take: takes the warning that it cannot follow.
        """
        self._name = name
        self._opening = opening
        self._take = take
        self._waiting: queue.Queue[Event | None] = queue.Queue(MOST_WAITING)
        self._opened = threading.Event()
        self._failure: Exception | None = None
        self._late = False
        self._thread = threading.Thread(target=self._work, name="voz-aside", daemon=True)

    def __enter__(self) -> Receiver:
        """Open the receiver; raises what that raises."""
        self._thread.start()
        self._opened.wait()
        self._raise()
        return self._receive

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            self._waiting.put(None, timeout=CLOSING_TIME)
        except queue.Full:
            return
        self._thread.join(CLOSING_TIME)
        if kind is None:
            self._raise()

    def _receive(self, event: Event) -> None:
        self._raise()
        try:
            self._waiting.put_nowait(event)
        except queue.Full:
            if not self._late:
                self._late = True
                text = f"{self._name}: cannot be written fast enough; events are missing"
                self._take(Warning(event.t, text))

    def _raise(self) -> None:
        failure, self._failure = self._failure, None
        if failure:
            raise failure

    def _work(self) -> None:
        try:
            with self._opening as write:
                self._opened.set()
                while (event := self._waiting.get()) is not None:
                    write(event)
        except Exception as error:  # it belongs to those who send the events
            self._failure = error
        finally:
            self._opened.set()
