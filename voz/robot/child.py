"""The program of a robot's own process; `voz.robot.robot_process` is the other end.

When no event comes, it stops the robot again and again: as long as the run is silent, and for a
short time when the run has been killed or has crashed.
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
from voz.process.forks import close_in_forks, ends_forks
from voz.robot.base import Robot
from voz.robot.factory import make_in_process
from voz.robot.robot_process import EventAnswer, RobotSpec
from voz.robot.user_code import error_line, lost_reason, user_errors_as_mistake

RUN_TIMEOUT = 0.5
"""Without an event for this time, s, the run is lost; bases wait as long for a velocity."""

ZERO_INTERVAL = 0.1
"""How often a robot is stopped while the run is lost, s."""

FINAL_ZEROS = 5
"""Zero velocities after the end of the run: a message may be lost."""


class WatchedRobot:
    """A robot that is stopped while its run is silent."""

    def __init__(self, robot: Robot, only_zero: bool) -> None:
        self._robot = robot
        self._only_zero = only_zero
        self._last = 0.0  # when the last velocity was sent, s
        self._silent = False
        self._has_velocity = False

    @property
    def watches(self) -> bool:
        """Whether silence means that the run is lost; for a watchdog from the beginning."""
        return self._has_velocity or self._only_zero

    def take(self, event: Event) -> EventAnswer:
        """Hand an event on; after a silence, only velocities after the run's own zero."""
        if isinstance(event, Twist):
            self._has_velocity = True
            self._last = event.t
            if not (event.linear or event.angular):
                self._silent = False
            elif self._silent:
                event = Twist(event.t, 0.0, 0.0)
        return self._do(event)

    def stop(self) -> None:
        """Stop the robot, as the run is silent."""
        self._silent = self._has_velocity  # before the first velocity nothing is lost
        self._do(Twist(self._last, 0.0, 0.0), even_if_another_drives=True)

    def _do(self, event: Event, even_if_another_drives: bool = False) -> EventAnswer:
        silent = f"nothing came for {RUN_TIMEOUT:g} s" if self._silent else None
        try:
            with ends_forks():
                if even_if_another_drives or not self._only_zero:
                    self._robot.receive(event)
                return EventAnswer(trouble=silent or lost_reason(self._robot))
        except BaseException as error:  # `sys.exit` in a robot must not end its watchdog
            return EventAnswer(failure=error_line(error))


def main() -> None:
    """Run a robot until the other end is closed."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, lambda *_: None)  # it ends when the run does, and stops the robot
    nowhere = os.open(os.devnull, os.O_WRONLY)  # now, since the robot may use up all descriptors
    link = Connection(int(sys.argv.pop()))
    close_in_forks(link)
    spec = msgspec.json.decode(link.recv_bytes(), type=RobotSpec)
    sys.path += [place for place in spec.path if place not in sys.path]
    with ExitStack() as closing:
        try:
            with ends_forks(), user_errors_as_mistake(spec.name):
                robot = make_in_process(spec)
                robot.open()
                closing.callback(_close, robot)
                begun = EventAnswer(trouble=lost_reason(robot))
        except BaseException as error:
            with suppress(OSError):  # the run may have ended meanwhile
                _answer(link, EventAnswer(error_line(error), traceback=_traceback(error)))
            return
        guarded = WatchedRobot(robot, spec.only_zero)
        try:
            _answer(link, begun)
            serve(link, guarded)
        except BaseException as error:  # the run has ended, or has lost this robot
            with suppress(BaseException):
                _answer(link, EventAnswer(error_line(error)))
            stop_after_run(guarded, nowhere)


def _traceback(error: BaseException) -> str:
    lines = traceback.format_exception(error.__cause__) if error.__cause__ else []
    return "".join(lines).encode(errors="backslashreplace").decode()


def _close(robot: Robot) -> None:
    try:
        with ends_forks():
            robot.close()
    except BaseException as error:
        with suppress(OSError):  # nobody may read it any more
            print(f"the robot could not be closed: {error_line(error)}")


def serve(link: Connection, robot: WatchedRobot) -> None:
    """Take events until the run is over; raises EOFError if it ends without saying so."""
    timeout = RUN_TIMEOUT if robot.watches else None
    while True:
        if not link.poll(timeout):
            robot.stop()
            timeout = ZERO_INTERVAL
            continue
        data = link.recv_bytes()
        if not data:
            return
        _answer(link, robot.take(msgspec.json.decode(data, type=Event)))
        timeout = RUN_TIMEOUT if robot.watches else None


def stop_after_run(robot: WatchedRobot, nowhere: int) -> None:
    """Go on to stop it for a while, and print nowhere."""
    for descriptor in (1, 2):  # nobody reads its output any more, and writing must not fail
        os.dup2(nowhere, descriptor)
    for _ in range(FINAL_ZEROS):
        robot.stop()
        time.sleep(ZERO_INTERVAL)


def _answer(link: Connection, answer: EventAnswer) -> None:
    link.send_bytes(msgspec.json.encode(answer))
