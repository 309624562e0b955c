"""Lets recordings and typed lines come at their own pace: for robots, whose clock is the real one.

The events are the same as without a clock, if the computer can follow and the lines are there.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterator

from voz.inbox import End, Inbox
from voz.run.beat import BEATS_PER_SECOND, beats_before
from voz.run.clocks import Item, PacedClock

AHEAD = 256
"""So much is decoded or read ahead."""

EARLY = 0.02
"""So much before its time is an item handed over, s: then it comes before the beat of that time."""


GONE = End(RuntimeError("nobody plays any more"))
"""Whatever ends one of the threads ends the run: the next line may be `stop`."""


def pace(items: Iterator[Item], inbox: Inbox, clock: PacedClock) -> None:
    """Begin to put items into an inbox, each at its time, on threads of their own.

    Args:
        items: in the order of their times; after the last of them the run ends. An error in their
            place ends it too.
        inbox: where to.
        clock: tells what time it is.
    """
    ready: queue.Queue[Item | End] = queue.Queue(AHEAD)
    for name, work in (
        ("voz-ahead", lambda: _read_ahead(items, ready)),
        ("voz-pace", lambda: _hand_over(ready, inbox, clock)),
    ):
        threading.Thread(target=work, name=name, daemon=True).start()


def _read_ahead(items: Iterator[Item], ready: queue.Queue[Item | End]) -> None:
    end = GONE
    try:
        for item in items:
            ready.put(item)
        end = End()
    except Exception as error:  # it belongs to who waits for the items
        end = End(error)
    finally:
        ready.put(end)


def _hand_over(ready: queue.Queue[Item | End], inbox: Inbox, clock: PacedClock) -> None:
    end = GONE
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
    while (left := until - EARLY - clock.exactly()) > 0:  # its time may stand still
        time.sleep(left)
