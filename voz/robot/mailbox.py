"""Delivers events to a robot on its own thread, and long work on another: none blocks the run."""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque
from collections.abc import Callable
from queue import Empty, SimpleQueue
from types import TracebackType

from voz.errors import RobotError
from voz.events import Event, Twist
from voz.process.forks import ends_forks
from voz.robot.base import Robot
from voz.robot.user_code import describe_error, error_line, lost_reason, user_errors_as_mistake

EVENTS_BEFORE_VELOCITY = 4
"""A velocity waits behind no more other events: a command causes a partial, an utterance, an
object and a reply."""

MAX_MAILBOX_EVENTS = 64
"""If more events wait, the oldest is dropped and the robot is lost."""

EVENT_TIMEOUT = 0.35
"""A robot that takes this time for one event, s, is lost: with the beat, half a second. A velocity
that waited as long is out of date."""

ROBOT_CLOSING_TIME = 1.0
"""Time for a robot to take the events that wait and to close, s."""


_driven: dict[int, Robot] = {}
"""The robots of this process that are open, by their ids."""

_driven_changes = threading.Lock()


class EventBox:
    """The newest velocity, and a bounded queue of other events. Pure.

    A velocity replaces the one that waits. A zero that stops the robot overtakes all; a zero after
    a zero does not, or a robot slower than the beat would get no command.
    """

    def __init__(self) -> None:
        self._others: deque[Event] = deque(maxlen=MAX_MAILBOX_EVENTS)
        self._velocity: Twist | None = None
        self._before = 0  # how many of the others come before the velocity
        self._stands = False  # whether the velocity that was taken last is zero

    def put(self, event: Event) -> None:
        """Add an event."""
        if not isinstance(event, Twist):
            self._others.append(event)
            return
        if self._velocity is None:
            self._before = min(len(self._others), EVENTS_BEFORE_VELOCITY)
        if _is_zero(event) and not self._stands:
            self._before = 0
        self._velocity = event

    def take(self) -> Event | None:
        """Remove and return the first event, or None."""
        velocity = self._velocity
        if velocity and not self._before:
            self._velocity = None
            self._stands = _is_zero(velocity)
            return velocity
        if not self._others:
            return None
        self._before = max(0, self._before - 1)
        return self._others.popleft()

    @property
    def full(self) -> bool:
        """Whether there is no room for another event."""
        return len(self._others) == MAX_MAILBOX_EVENTS


def _is_zero(velocity: Twist) -> bool:
    return not (velocity.linear or velocity.angular)


class Mailbox:
    """Takes events without waiting, and delivers them to a robot that is open in a `with` block.

    A robot that raised is lost for good; it still gets zero velocities.
    """

    def __init__(
        self, name: str, robot: Robot, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Prepare to hand events to a robot; the name is for messages, the clock gives s."""
        self.hangs = False  # whether it did not take all events before the end
        self._clock = clock
        self._name = name
        self._robot = robot
        self._box = EventBox()
        self._changed = threading.Condition()
        self._closing = False
        self._failure: str | None = None
        self._answer: str | None = None  # why the robot said that it is lost, after the last event
        self._untold: str | None = None  # the same, until `lost` has returned it
        self._busy_since: float | None = None
        self._put_at = 0.0  # when the velocity that waits was put there, s
        self._taken_put_at = 0.0  # the same of the velocity that was taken last
        self._thread = threading.Thread(target=self._work, name=f"voz-{name}", daemon=True)

    def __enter__(self) -> Mailbox:
        """Open the robot; raises what it raises, and RobotError if it is open already."""
        with user_errors_as_mistake(self._name), contextlib.ExitStack() as undo:
            self._claim()
            undo.callback(self._release)
            self._robot.open()
            undo.callback(self._robot.close)
            self._answer = lost_reason(self._robot)
            self._thread.start()
            undo.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self.finish()
        self._thread.join(ROBOT_CLOSING_TIME)
        self.hangs = self._thread.is_alive()

    @property
    def failure(self) -> str | None:
        """Why the robot took no more events at the end; None if it took them all."""
        return self._failure or (
            "it did not take its last velocity in time" if self.hangs else None
        )

    def finish(self) -> None:
        """Let the robot take the waiting events and close, without waiting for it."""
        with self._changed:
            self._closing = True
            self._changed.notify()

    def receive(self, event: Event) -> None:
        """Take an event; this never waits for the robot."""
        with self._changed:
            if isinstance(event, Twist):
                self._put_at = self._clock()
            self._box.put(event)
            self._changed.notify()

    def lost(self) -> str | None:
        """Return why the robot is lost, or was since the last call; None if not. Never waits."""
        with self._changed:  # or what the robot says at this moment would never be told
            untold, self._untold = self._untold, None
        problem = self._failure or self._answer or untold
        busy_since = self._busy_since
        if busy_since is not None and self._clock() - busy_since > EVENT_TIMEOUT:
            problem = "does not take its events"
        elif self._box.full:
            problem = "cannot keep up"
        elif not (self._closing or self._thread.is_alive()):
            problem = "its delivery thread died"
        return f"the robot {self._name} is lost ({problem})" if problem else None

    def _work(self) -> None:
        over = False
        while not over:
            try:
                over = self._hand_over()
            except BaseException as error:  # between two events; the robot must still be stopped
                self._failure = self._failure or describe_error(error)
        with contextlib.suppress(BaseException), ends_forks():  # it is used no more
            self._robot.close()
        self._release()

    def _claim(self) -> None:
        """Keep others from the robot: of two that drive it, neither could stop it."""
        with _driven_changes:
            if id(self._robot) in _driven:
                raise RobotError(
                    f"{self._name}: another controller drives this robot already",
                    "end that one first; all that drives a robot goes through one controller",
                )
            _driven[id(self._robot)] = self._robot

    def _release(self) -> None:
        with _driven_changes:
            _driven.pop(id(self._robot), None)

    def _hand_over(self) -> bool:
        while (event := self._next()) is not None:
            self._busy_since = self._clock()
            self._deliver(event)
            self._busy_since = None
        return True

    def _next(self) -> Event | None:
        with self._changed:
            while (event := self._box.take()) is None and not self._closing:
                self._changed.wait()
            self._taken_put_at = self._put_at  # the next one may come while it is delivered
            return event

    def _deliver(self, event: Event) -> None:
        if self._failure and not isinstance(event, Twist):
            return
        if isinstance(event, Twist):
            late = self._clock() - self._taken_put_at > EVENT_TIMEOUT
            # A velocity from the time of a loss must not be driven, nor one before all stopped.
            if late or self._failure or self._answer or self._untold:
                event = Twist(event.t, 0.0, 0.0)
        try:
            with ends_forks():
                self._robot.receive(event)
                answer = lost_reason(self._robot)
            with self._changed:
                self._answer = answer
                self._untold = answer or self._untold
        except BaseException as error:  # whatever it is, `sys.exit` too, the others go on
            self._failure = self._failure or error_line(error)


WORK_CLOSING_TIME = 0.5
"""Time for work that waits at the end of the run, s; half of `ROBOT_CLOSING_TIME`."""


class SlowRobot(Robot):
    """Delivers velocities at once and other events on another thread.

    A stop must not wait behind three seconds of work.
    """

    def __init__(self, robot: Robot) -> None:
        """Prepare to hand events to a robot whose `slow` is true."""
        self._robot = robot
        self._waiting: SimpleQueue[Event | None] = SimpleQueue()
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
            if self._is_full():
                with contextlib.suppress(Empty):
                    self._waiting.get_nowait()
            self._waiting.put(event)
        if self._failure:
            raise self._failure.with_traceback(self._place)  # else it grows each time it is raised

    def lost(self) -> str | None:
        """Return why the robot is lost; also while too many events wait."""
        return "cannot keep up" if self._is_full() else self._robot.lost()

    def close(self) -> None:
        """Give the robot a moment to finish its work, and close it."""
        self._waiting.put(None)
        self._worker.join(WORK_CLOSING_TIME)
        self._robot.close()

    def _work(self) -> None:
        while event := self._waiting.get():
            try:
                with ends_forks():
                    self._robot.receive(event)
            except BaseException as error:  # `sys.exit` too; it is raised at the next velocity
                self._place = error.__traceback__
                self._failure = error
                return

    def _is_full(self) -> bool:
        return self._waiting.qsize() >= MAX_MAILBOX_EVENTS
