"""Drives by recordings or typed lines at their own pace: for robots, whose clock is the real one.

The events are the same as without a clock, if the computer can follow and the lines are there.
"""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress

from voz.config import Safety
from voz.drive import CYCLES_PER_SECOND, SWITCH
from voz.events import Partial, Receiver, Utterance
from voz.live.loop import take
from voz.live.messages import Inbox
from voz.pipeline import Item, Pipeline
from voz.watch import over_robots

LEAD = 0.2
"""So long after the start is time 0, s: by then the first of a recording is decoded."""

AHEAD = 256
"""So much is decoded or read ahead."""


class RealtimePipeline(Pipeline):
    """The same as `Pipeline`, by the clock, and it looks after the robots (S5)."""

    def __init__(
        self,
        receivers: Sequence[Receiver],
        safety: Safety,
        listening: bool = False,
        lost: Mapping[str, Callable[[], str | None]] | None = None,
        inbox: Inbox | None = None,
    ) -> None:
        """Start with the robot at rest; time 0 is soon.

        Args:
            receivers: as for `Drive`.
            safety: the same.
            listening: the same.
            lost: tells of each robot, by its name, why it is lost.
            inbox: what other threads want to be told.
        """
        super().__init__(receivers, safety, listening)
        sys.setswitchinterval(SWITCH)
        self._watches = over_robots(self, lost or {})
        self._inbox = inbox or queue.SimpleQueue()
        self._begun = time.monotonic() + LEAD

    def hear(self, event: Utterance | Partial) -> None:
        """Let the time before something was heard pass, then take it."""
        self.pass_until(event.t)
        time.sleep(max(0.0, self._left(event.t)))
        super().hear(event)

    def cycle(self) -> None:
        """Wait until it is time, then send the velocities once."""
        left = self._left(self.now)
        time.sleep(max(0.0, left))
        if left < -1 / CYCLES_PER_SECOND:
            self._begun -= left  # after a pause all goes on, later; a robot must not hurry
        with suppress(queue.Empty):
            while True:
                take(self, self._inbox.get_nowait())
        for watch in self._watches:
            watch.look(self.now)
        super().cycle()

    def awaited(self, items: Iterable[Item]) -> Iterator[Item]:
        """Give what comes when it is there, and let cycles pass while it is not."""
        ready: queue.Queue[Item | _End] = queue.Queue(AHEAD)
        threading.Thread(
            target=_read_ahead, args=(items, ready), name="voz-ahead", daemon=True
        ).start()
        while True:
            try:
                item = ready.get(timeout=max(0.0, self._left(self.now)))
            except queue.Empty:
                self.cycle()
                continue
            if not isinstance(item, _End):
                yield item
            elif item.error:
                raise item.error
            else:
                return

    def _left(self, t: float) -> float:
        """How long it is until a time of the run, s."""
        return self._begun + t - time.monotonic()


class _End:
    """Nothing more comes, or an error in its place."""

    def __init__(self, error: Exception | None = None) -> None:
        self.error = error


def _read_ahead(items: Iterable[Item], ready: queue.Queue[Item | _End]) -> None:
    try:
        for item in items:
            ready.put(item)
    except Exception as error:  # it belongs to the thread that waits for the items
        ready.put(_End(error))
    else:
        ready.put(_End())
