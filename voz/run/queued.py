"""Receivers behind a queue, each on a thread of its own: the robot never waits for a disk."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress

from voz.control.messages import End
from voz.events import Event, Notice, Receiver

MAX_QUEUED_EVENTS = 6000
"""Waiting for a slow disk or reader: ten minutes of events."""

EVENT_FLUSH_TIMEOUT = 3.0
"""To write what waits when the run is over, s; some readers never read it."""


class QueuedReceiver:
    """Hands events to a receiver that may be slow, without waiting for it.

    The `with` block opens the receiver; its end writes what is queued and closes it. An error of
    the receiver ends the run; if the run is over already, the block raises it.
    """

    def __init__(
        self,
        name: str,
        opening: AbstractContextManager[Receiver],
        report: Callable[[Notice | End], None],
    ) -> None:
        """Prepare a queue.

        Args:
            name: what is written, for messages.
            opening: opens the receiver; entered and left on the other thread.
            report: takes the warning that it is too slow, and the end of the run by an error.
        """
        self._name = name
        self._opening = opening
        self._report = report
        self._waiting: queue.Queue[Event | None] = queue.Queue(MAX_QUEUED_EVENTS)
        self._opened = threading.Event()
        self._failure: Exception | None = None
        self._warned = False
        self._thread = threading.Thread(target=self._work, name="voz-queued", daemon=True)

    def __enter__(self) -> Receiver:
        """Open the receiver; raises what that raises."""
        self._thread.start()
        self._opened.wait()
        if self._failure:
            raise self._failure
        return self._receive

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if not self._failure:
            with suppress(queue.Full):
                self._waiting.put(None, timeout=EVENT_FLUSH_TIMEOUT)
                self._thread.join(EVENT_FLUSH_TIMEOUT)
        if kind is None and self._failure:
            raise self._failure

    def _receive(self, event: Event) -> None:
        try:
            self._waiting.put_nowait(event)
        except queue.Full:
            if not self._warned and not self._failure:
                self._warned = True
                text = f"{self._name}: cannot be written fast enough; events are missing"
                self._report(Notice(event.t, text))

    def _work(self) -> None:
        try:
            with self._opening as write:
                self._opened.set()
                while (event := self._waiting.get()) is not None:
                    write(event)
        except BaseException as error:  # it ends the run, which sends the events
            self._failure = error if isinstance(error, Exception) else RuntimeError(repr(error))
            if self._opened.is_set():
                self._report(End(self._failure))
        finally:
            self._opened.set()
