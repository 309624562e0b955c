"""Lets recordings and typed lines come at their own pace, for robots that need the real time.

The events are the same as without a clock, if the computer is fast enough.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterator

from voz.control.messages import End
from voz.inbox import Inbox
from voz.run.beat import BEATS_PER_SECOND, beats_before
from voz.run.clocks import Item, PacedClock

MAX_ITEMS_AHEAD = 256
"""Items that are decoded or read before their time."""

HANDOVER_LEAD = 0.02
"""An item is handed over this long before its time, s: before the beat of that time."""


SOURCE_DIED = End(RuntimeError("the source of commands died"))
"""A thread that dies ends the run: the next line may be `stop`."""


def pace(items: Iterator[Item], inbox: Inbox, clock: PacedClock) -> None:
    """Put items into an inbox, each at its time, on threads of their own.

    Args:
        items: in the order of their times; their end, or an error, ends the run.
        inbox: gets them.
        clock: the time of the run.
    """
    ready: queue.Queue[Item | End] = queue.Queue(MAX_ITEMS_AHEAD)
    for name, work in (
        ("voz-ahead", lambda: _read_ahead(items, ready)),
        ("voz-pace", lambda: _hand_over(ready, inbox, clock)),
    ):
        threading.Thread(target=work, name=name, daemon=True).start()


def _read_ahead(items: Iterator[Item], ready: queue.Queue[Item | End]) -> None:
    end = SOURCE_DIED
    try:
        for item in items:
            ready.put(item)
        end = End()
    except Exception as error:  # it is raised where the items are awaited
        end = End(error)
    finally:
        ready.put(end)


def _hand_over(ready: queue.Queue[Item | End], inbox: Inbox, clock: PacedClock) -> None:
    end = SOURCE_DIED
    over = 0.0
    try:
        while not isinstance(item := ready.get(), End):
            if isinstance(item, float):
                over = item
            else:
                _wait(item.t, clock)
                inbox.put(item)
        _wait(beats_before(over) / BEATS_PER_SECOND, clock)
        end = item
    finally:
        inbox.put(end)


def _wait(until: float, clock: PacedClock) -> None:
    while (left := until - HANDOVER_LEAD - clock.exactly()) > 0:  # its time may stand still
        time.sleep(left)
