"""The one loop that drives a robot: 10 times a second, and at once when something is heard.

It takes what arrived, applies the rules and hands velocities on. It writes nothing, opens nothing
and waits for nobody: whatever may do so is behind a queue, as a receiver or as a source.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

from voz.events import Partial, Utterance
from voz.inbox import End, Halt, Rehearsal, Renewal, TakenMessage
from voz.run.clocks import Clock
from voz.run.controller import Controller

BEATS_PER_SECOND = 10
"""How often `cmd_vel` goes out, also while nothing is said."""

MAX_BEAT_GAP = 0.5
"""Longest time between two beats, s; a base has stopped by itself then, and must stay so."""


Look: TypeAlias = Callable[[float], None]


def beat(
    controller: Controller, clock: Clock, looks: Sequence[Look] = (), at_once: bool = False
) -> BaseException | None:
    """Drive until the run is over; return the error that ended it, if one did.

    Args:
        controller: what obeys.
        clock: the time, and what arrives.
        looks: called in each beat with its time, s.
        at_once: whether a changed velocity is sent before the next beat.
    """
    number = 0
    last = clock.now()
    while True:
        due = number / BEATS_PER_SECOND
        taken = clock.take(due)
        now = clock.now()
        # First of all: a process that was suspended must not drive on.
        if now - last > MAX_BEAT_GAP:
            gap = now - last
            clock.skip(now - due)
            controller.stop(clock.now(), f"control loop stalled for {gap:.1f} s: the robot stops")
            last = now = clock.now()
        if taken is None:
            for look in looks:
                look(now)
            controller.send(now)
            last = now
            number = max(number, int(now * BEATS_PER_SECOND)) + 1  # missed beats are left out
        elif isinstance(taken.message, End):
            return taken.message.error
        else:
            before = controller.velocities
            take(controller, taken, now)
            now = clock.now()
            if at_once and controller.velocities != before and now - last <= MAX_BEAT_GAP:
                controller.send(now)


def take(controller: Controller, taken: TakenMessage, now: float) -> None:
    """Let a message take effect at a time of the run, s."""
    message = taken.message
    if isinstance(message, Utterance | Partial):
        controller.hear(message, late=taken.overtaken)
    elif isinstance(message, Halt):
        controller.stop_by_hand(now, message.why, message.t)
    elif isinstance(message, Rehearsal):
        controller.rehearsing = message.on
    elif isinstance(message, Renewal):
        controller.renew(now, message)
    elif not isinstance(message, End):
        controller.emit(message)


def beats_before(t: float) -> int:
    """Count the beats before a time of the run, s."""
    return max(0, math.ceil(round(t * BEATS_PER_SECOND, 6)))
