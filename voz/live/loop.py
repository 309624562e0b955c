"""The loop that drives the robot: 10 times a second, and at once when something is heard."""

from __future__ import annotations

import queue
from collections.abc import Callable, Sequence
from typing import NoReturn

from voz.drive import CYCLES_PER_SECOND, Drive
from voz.events import Partial, Utterance
from voz.live.messages import Halt, Inbox, Message
from voz.pipeline import TYPED
from voz.watch import Watch

CYCLE = 1 / CYCLES_PER_SECOND


def drive_live(
    drive: Drive,
    inbox: Inbox,
    trouble: Callable[[], str | None],
    clock: Callable[[], float],
    watches: Sequence[Watch] = (),
) -> NoReturn:
    """Drive the robot until a signal ends the program.

    A changed velocity is sent at once, and the beat of 10 Hz goes on from where it was.

    Args:
        drive: what obeys.
        inbox: what is heard and typed, and what goes wrong.
        trouble: tells why nothing is heard right now; asked in each cycle (S5).
        clock: the time of the run, s.
        watches: look after what else is needed, in each cycle too.
    """
    cycle = 0
    hearing = Watch(drive, trouble, "listening again")
    while True:
        now = clock()
        due = cycle * CYCLE
        if now < due:
            try:
                message = inbox.get(timeout=due - now)
            except queue.Empty:
                continue
            before = drive.velocities
            take(drive, message)
            if hearing.lost and isinstance(message, Utterance) and message.source != TYPED:
                drive.halt()  # said long ago: hearing is behind
            if drive.velocities != before:
                drive.send(stamp(clock()))
            continue
        for watch in (hearing, *watches):
            watch.look(stamp(now))
        drive.send(stamp(now))
        cycle = max(cycle, int(now * CYCLES_PER_SECOND)) + 1  # a beat that was missed is left out


def take(drive: Drive, message: Message) -> None:
    """Let what is heard or typed take effect."""
    if isinstance(message, Utterance | Partial):
        drive.hear(message)
    elif isinstance(message, Halt):
        drive.halt()
    else:
        drive.emit(message)


def stamp(now: float) -> float:
    """A time as it is written into events, s."""
    return round(now, 4)
