"""A robot whose work may take long, though it is never late for a stop."""

from __future__ import annotations

import threading
from types import TracebackType

from voz.events import Event, Twist
from voz.process.forks import ends_forks
from voz.robot.base import Robot
from voz.robot.mailbox import EventBox

WORK_CLOSING_TIME = 0.5
"""Time for work that waits at the end of the run, s; half of `ROBOT_CLOSING_TIME`."""


class SlowRobot(Robot):
    """Delivers velocities at once and other events on another thread.

    A stop must not wait behind three seconds of work.
    """

    def __init__(self, robot: Robot) -> None:
        """Prepare to hand events to a robot whose `slow` is true."""
        self._robot = robot
        self._box = EventBox()
        self._changed = threading.Condition()
        self._closing = False
        self._failure: BaseException | None = None
        self._place: TracebackType | None = None  # where it was raised
        self._worker = threading.Thread(target=self._work, name="voz-slow", daemon=True)

    def open(self) -> None:
        """Open the robot; raises what it raises."""
        self._robot.where = self.where
        self._robot.open()
        self._worker.start()

    def receive(self, event: Event) -> None:
        """Pass a velocity on, or queue the event for the other thread; raises its errors."""
        if isinstance(event, Twist):
            self._robot.receive(Twist(event.t, 0.0, 0.0) if self._failure else event)
        else:
            with self._changed:
                self._box.put(event)
                self._changed.notify()
        if self._failure:
            raise self._failure.with_traceback(self._place)  # else it grows each time it is raised

    def lost(self) -> str | None:
        """Return why the robot is lost; also while too many events wait."""
        return "cannot keep up" if self._box.full else self._robot.lost()

    def close(self) -> None:
        """Give the robot a moment to finish its work, and close it."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._worker.join(WORK_CLOSING_TIME)
        self._robot.close()

    def _work(self) -> None:
        while event := self._next():
            try:
                with ends_forks():
                    self._robot.receive(event)
            except BaseException as error:  # `sys.exit` too; it is raised at the next velocity
                self._place = error.__traceback__
                self._failure = error
                return

    def _next(self) -> Event | None:
        with self._changed:
            while (event := self._box.take()) is None and not self._closing:
                self._changed.wait()
            return event
