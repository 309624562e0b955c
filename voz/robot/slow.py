"""A robot that takes its time for what is no velocity, without being late for a stop."""

from __future__ import annotations

import threading
from types import TracebackType

from voz.events import Event, Twist
from voz.robot.base import Robot
from voz.robot.mailbox import Box

CLOSING_TIME = 0.5
"""For work to be done at the end of the run, s; whoever waits for the robot gives it twice that."""


class SlowRobot(Robot):
    """Hands a robot its velocities at once, and all else on a thread of its own.

    Two lanes and not one: a velocity that waits behind three seconds of work is a stop that comes
    three seconds late, by a robot that answers as if all were well.
    """

    def __init__(self, robot: Robot) -> None:
        """Prepare to hand events to a robot whose `slow` is true."""
        self._robot = robot
        self._box = Box()
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
        """Hand a velocity on, or keep the event for the other thread; raises what failed there."""
        if isinstance(event, Twist):
            self._robot.receive(Twist(event.t, 0.0, 0.0) if self._failure else event)
        else:
            with self._changed:
                self._box.put(event)
                self._changed.notify()
        if self._failure:
            raise self._failure.with_traceback(self._place)  # else it grows each time it is raised

    def lost(self) -> str | None:
        """Tell why the robot is lost; also while too much waits for it."""
        return "cannot follow" if self._box.full else self._robot.lost()

    def close(self) -> None:
        """Let the robot do what waits, for a moment, and close."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._worker.join(CLOSING_TIME)
        self._robot.close()

    def _work(self) -> None:
        while event := self._next():
            try:
                self._robot.receive(event)
            except BaseException as error:  # `sys.exit` too: the next velocity tells of it
                self._place = error.__traceback__
                self._failure = error
                return

    def _next(self) -> Event | None:
        with self._changed:
            while (event := self._box.take()) is None and not self._closing:
                self._changed.wait()
            return event
