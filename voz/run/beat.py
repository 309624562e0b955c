"""The one loop that drives a robot: 10 times a second, and at once when something is heard.

It takes what arrived, applies the rules and hands velocities on. It writes nothing, opens nothing
and waits for nobody: whatever may do so is behind a queue, as a receiver or as a source.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

from voz.control.messages import Beat, End, StopMotion
from voz.run.clocks import Clock
from voz.run.dispatcher import Dispatcher

BEATS_PER_SECOND = 10
"""How often `cmd_vel` goes out, also while nothing is said."""

MAX_BEAT_GAP = 0.5
"""Longest time between two beats, s; a base has stopped by itself then, and must stay so."""


Check: TypeAlias = Callable[[float], None]


def beat(
    dispatcher: Dispatcher, clock: Clock, checks: Sequence[Check] = (), at_once: bool = False
) -> BaseException | None:
    """Drive until the run is over; return the error that ended it, if one did.

    Args:
        dispatcher: takes what arrives.
        clock: the time, and what arrives.
        checks: called in each beat with its time, s.
        at_once: whether a changed velocity is sent before the next beat.
    """
    number = 0
    last = clock.now()
    while True:
        due = number / BEATS_PER_SECOND
        message = clock.next_before(due)
        now = clock.now()
        # First of all: a process that was suspended must not drive on.
        if now - last > MAX_BEAT_GAP:
            gap = now - last
            clock.skip(now - due)
            why = f"control loop stalled for {gap:.1f} s: the robot stops"
            dispatcher.take(StopMotion(why), clock.now())
            last = now = clock.now()
        if message is None:
            for check in checks:
                check(now)
            dispatcher.take(Beat(), now)
            last = now
            number = max(number, int(now * BEATS_PER_SECOND)) + 1  # missed beats are left out
        elif isinstance(message, End):
            return message.error
        else:
            before = dispatcher.velocities
            dispatcher.take(message, now)
            now = clock.now()
            if at_once and dispatcher.velocities != before and now - last <= MAX_BEAT_GAP:
                dispatcher.take(Beat(), now)


def beats_before(t: float) -> int:
    """Count the beats before a time of the run, s."""
    return max(0, math.ceil(round(t * BEATS_PER_SECOND, 6)))
