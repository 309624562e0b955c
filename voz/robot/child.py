"""The process that a robot has of its own; `voz.robot.robot_process` is the other end of it.

When no event comes any more the robot is stopped, again and again: for as long as the run is
silent, and for a while when it has ended without a word.
"""

from __future__ import annotations

import os
import signal
import sys
import time
import traceback
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection

import msgspec

from voz.events import Event, Twist
from voz.robot.base import Robot
from voz.robot.factory import make_apart
from voz.robot.robot_process import Answer, RobotSpec
from voz.robot.user_errors import mistakes_told, reason, why_lost

SILENCE = 0.5
"""Without an event for so long the run is lost, s: as long as bases wait for a velocity."""

BEAT = 0.1
"""How often a robot is stopped while the run is lost, s."""

LAST_ZEROS = 5
"""So often it is stopped when the run has ended: a message may be lost."""


class Guarded:
    """The robot, and whether the run that drives it is there."""

    def __init__(self, robot: Robot, only_zero: bool) -> None:
        self._robot = robot
        self._only_zero = only_zero
        self._last = Twist(0.0, 0.0, 0.0)
        self._silent = False
        self._driven = False

    @property
    def watches(self) -> bool:
        """Whether silence means that the run is lost.

        Of a robot that another process drives it does from the beginning: that one may get the
        first velocity before this one does, and no other ever.
        """
        return self._driven or self._only_zero

    def take(self, event: Event) -> Answer:
        """Hand an event on; after a silence no motion, until the run itself has ended it."""
        if isinstance(event, Twist):
            self._driven = True
            self._last = event
            if not (event.linear or event.angular):
                self._silent = False
            elif self._silent:
                event = Twist(event.t, 0.0, 0.0)
        return self._do(event)

    def stop(self) -> None:
        """Let the robot stand still, as the run is silent."""
        self._silent = self._driven  # before the first velocity nobody has lost anything
        self._do(Twist(self._last.t, 0.0, 0.0), even_if_another_drives=True)

    def _do(self, event: Event, even_if_another_drives: bool = False) -> Answer:
        silent = f"nothing came for {SILENCE:g} s" if self._silent else None
        try:
            if even_if_another_drives or not self._only_zero:
                self._robot.receive(event)
            return Answer(trouble=silent or why_lost(self._robot))
        except BaseException as error:  # `sys.exit` in a robot must not end its watchdog
            return Answer(failure=reason(error))


def main() -> None:
    """Be a robot until the other end is closed."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, lambda *_: None)  # it ends when the run does, and stops the robot
    nowhere = os.open(os.devnull, os.O_WRONLY)  # now, as the robot may take all descriptors
    link = Connection(int(sys.argv.pop()))
    order = msgspec.json.decode(link.recv_bytes(), type=RobotSpec)
    sys.path += [place for place in order.path if place not in sys.path]
    with ExitStack() as closing:
        try:
            with mistakes_told(order.name):
                robot = make_apart(order)
                robot.open()
                closing.callback(_close, robot)
                begun = Answer(trouble=why_lost(robot))
        except BaseException as error:
            with suppress(OSError):  # the run may have ended meanwhile
                _answer(link, Answer(reason(error), traceback=_traceback(error)))
            return
        guarded = Guarded(robot, order.only_zero)
        try:
            _answer(link, begun)
            _serve(link, guarded)
        except BaseException as error:  # the run has ended, or it will not hear of this robot again
            with suppress(BaseException):
                _answer(link, Answer(reason(error)))
            _forsaken(guarded, nowhere)


def _traceback(error: BaseException) -> str:
    """That of a mistake in the robot's own code, as a text that can be sent."""
    lines = traceback.format_exception(error.__cause__) if error.__cause__ else []
    return "".join(lines).encode(errors="backslashreplace").decode()


def _close(robot: Robot) -> None:
    try:
        robot.close()
    except BaseException as error:
        with suppress(OSError):  # nobody may read it any more
            print(f"the robot could not be closed: {reason(error)}")


def _serve(link: Connection, robot: Guarded) -> None:
    """Take events until the run says that it is over; raises EOFError if it ends without."""
    patience = SILENCE if robot.watches else None
    while True:
        if not link.poll(patience):
            robot.stop()
            patience = BEAT
            continue
        data = link.recv_bytes()
        if not data:
            return
        _answer(link, robot.take(msgspec.json.decode(data, type=Event)))
        patience = SILENCE if robot.watches else None


def _forsaken(robot: Guarded, nowhere: int) -> None:
    """Stop the robot as the run has ended without a word: killed, or crashed."""
    for descriptor in (1, 2):  # nobody reads any more what it prints, and that must not fail
        os.dup2(nowhere, descriptor)
    for _ in range(LAST_ZEROS):
        robot.stop()
        time.sleep(BEAT)


def _answer(link: Connection, answer: Answer) -> None:
    link.send_bytes(msgspec.json.encode(answer))
