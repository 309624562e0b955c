"""Hands events to a robot on a thread of its own: one that blocks or fails harms no other."""

from __future__ import annotations

import contextlib
import threading
import time
from collections import deque

from voz.events import Event, Twist
from voz.robot.base import Robot
from voz.robot.user_errors import in_words, mistakes_told, reason, why_lost

ONE_COMMAND = 4
"""What comes before the velocity that a command causes: a partial, the utterance, an object, a
reply. A velocity waits behind no more than that."""

MOST_WAITING = 64
"""Events that may wait besides the velocity; then the oldest goes, and the robot counts as lost."""

STUCK = 0.35
"""A robot that takes so long for one event is lost, s: with the beat, half a second. A velocity
that waited for so long is out of date."""

CLOSING_TIME = 1.0
"""For a robot to take what waits, the last velocity with it, and to close, s."""


class Box:
    """Events that wait: of the velocities the newest, of the others all up to a bound. Pure.

    A velocity takes the place of the one that waits. A zero that stops the robot overtakes all; a
    zero after a zero does not, or a robot that takes longer than a beat would get no command.
    """

    def __init__(self) -> None:
        self._others: deque[Event] = deque(maxlen=MOST_WAITING)
        self._velocity: Twist | None = None
        self._before = 0  # how many of the others come before the velocity
        self._stands = False  # whether the velocity that was taken last is zero

    def put(self, event: Event) -> None:
        """Add an event."""
        if not isinstance(event, Twist):
            self._others.append(event)
            return
        if self._velocity is None:
            self._before = min(len(self._others), ONE_COMMAND)
        if _is_zero(event) and not self._stands:
            self._before = 0
        self._velocity = event

    def take(self) -> Event | None:
        """Take the first event; None if none waits."""
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
        """Whether one more would be too many."""
        return len(self._others) == MOST_WAITING


def _is_zero(velocity: Twist) -> bool:
    return not (velocity.linear or velocity.angular)


class Mailbox:
    """What a run knows of a robot: takes its events at once, and tells whether it is lost.

    Use it in a `with` block: the robot is opened at its beginning, and at its end it gets what
    waits and is closed. A robot that raised is lost for good; it still gets velocities of zero.

    Attributes:
        hangs: whether it did not take all that it was to get, at the end.
    """

    def __init__(self, name: str, robot: Robot) -> None:
        """Prepare to hand events to a robot; the name is for messages."""
        self.hangs = False
        self._name = name
        self._robot = robot
        self._box = Box()
        self._changed = threading.Condition()
        self._closing = False
        self._failure: str | None = None
        self._answer: str | None = None  # why the robot said that it is lost, after the last event
        self._untold: str | None = None  # the same, until who looks after it has been told
        self._busy_since: float | None = None
        self._put_at = 0.0  # the velocity that waits, on the monotonic clock, s
        self._taken_put_at = 0.0  # the same of the one that was taken last
        self._thread = threading.Thread(target=self._work, name=f"voz-{name}", daemon=True)

    def __enter__(self) -> Mailbox:
        """Open the robot; raises what it raises."""
        with mistakes_told(self._name), contextlib.ExitStack() as undo:
            self._robot.open()
            undo.callback(self._robot.close)
            self._answer = why_lost(self._robot)
            self._thread.start()
            undo.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self.finish()
        self._thread.join(CLOSING_TIME)
        self.hangs = self._thread.is_alive()

    def finish(self) -> None:
        """Let the robot take what waits and close; this does not wait for it."""
        with self._changed:
            self._closing = True
            self._changed.notify()

    def receive(self, event: Event) -> None:
        """Take an event; this never waits for the robot."""
        with self._changed:
            if isinstance(event, Twist):
                self._put_at = time.monotonic()
            self._box.put(event)
            self._changed.notify()

    def lost(self) -> str | None:
        """Tell why the robot is lost, or was since the last call; None if not. This never waits."""
        untold, self._untold = self._untold, None
        problem = self._failure or self._answer or untold
        busy_since = self._busy_since
        if busy_since is not None and time.monotonic() - busy_since > STUCK:
            problem = "does not take its events"
        elif self._box.full:
            problem = "cannot follow"
        elif not (self._closing or self._thread.is_alive()):
            problem = "nobody hands it anything any more"
        return f"the robot {self._name} is lost ({problem})" if problem else None

    def _work(self) -> None:
        over = False
        while not over:
            try:
                over = self._hand_over()
            except BaseException as error:  # between two events; the robot is still to be stopped
                self._failure = self._failure or in_words(error)
        with contextlib.suppress(BaseException):  # nothing more is asked of it
            self._robot.close()

    def _hand_over(self) -> bool:
        """Hand over what comes, until the run is over."""
        while (event := self._next()) is not None:
            self._busy_since = time.monotonic()
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
            late = time.monotonic() - self._taken_put_at > STUCK
            # What is asked while it is lost must not be done, nor until all have stopped for that.
            if late or self._failure or self._answer or self._untold:
                event = Twist(event.t, 0.0, 0.0)
        try:
            self._robot.receive(event)
            self._answer = why_lost(self._robot)
            self._untold = self._answer or self._untold
        except BaseException as error:  # whatever it is, `sys.exit` too, the others go on
            self._failure = self._failure or reason(error)
