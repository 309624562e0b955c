"""Applies the controller's steps, and hands the events to all receivers, slow ones by a queue."""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress

from voz.control.controller import ControllerState, halted, step
from voz.control.messages import Beat, ControllerMessage, End, Halt, StopMotion
from voz.control.motion import Place
from voz.errors import ConfigError, RobotError
from voz.events import Event, Notice, Partial, Receiver, Twist, Utterance
from voz.printable import shown_value
from voz.process.forks import ends_forks
from voz.records import PublicNames, is_finite

MAX_TIME = 1e12
"""Of a run, s; events hold no later time."""


class Dispatcher(PublicNames):
    """Keeps the state of a run, takes messages, and hands events to receivers. On one thread.

    Attributes:
        state: of the controller; other threads may read it.
        receivers: called with every event, in order; none of them may wait for anything.
        odometry: returns where the robot is at a time of the run, s, without waiting.
    """

    def __init__(
        self,
        state: ControllerState,
        receivers: Sequence[Receiver] = (),
        odometry: Callable[[float], Place | None] = lambda _: None,
    ) -> None:
        self.state = state
        self.receivers = [*receivers]
        self.odometry = odometry
        self._process = os.getpid()

    @property
    def velocities(self) -> tuple[float, float]:
        """The velocities that are sent now, m/s and rad/s."""
        return self.state.robot.motion.velocities()

    @property
    def moving(self) -> bool:
        """Whether the robot is asked to move."""
        return self.state.robot.moving

    @property
    def listening(self) -> bool:
        """Whether commands are obeyed."""
        return self.state.robot.listening

    @property
    def awake(self) -> bool:
        """Whether spoken commands count, besides those that stop."""
        return self.state.reported.awake

    @property
    def name(self) -> str:
        """What the robot is called; empty if it has no name."""
        return self.state.rules.name

    @property
    def wake(self) -> str:
        """What is said to begin the listening; empty if the list has nothing for it."""
        return self.state.rules.table.wake

    def take(self, message: ControllerMessage, now: float) -> None:
        """Let a message take effect at a time of the run, s, and hand on what comes of it.

        Raises:
            ConfigError: the time is no number; a stop ends the motion all the same.
        """
        if isinstance(message, Halt | StopMotion):
            self.halt()
        if not isinstance(message, Utterance | Partial):
            check_time(now)
        self.state, events = step(self.state, message, now, self._place(message, now))
        self.emit(*events)

    def _place(self, message: ControllerMessage, now: float) -> Place | None:
        """Where odometry has the robot; an error of it halts the robot, also at a stop."""
        if isinstance(message, Partial | Utterance):
            moves = self.moving if isinstance(message, Partial) else message.accepted
            now = message.t
        else:
            moves = isinstance(message, Beat)
        try:
            return self.odometry(now) if moves else None
        except BaseException:
            self.halt()
            raise

    def halt(self) -> None:
        """Ask the robot to stand still from now on."""
        self.state = halted(self.state)

    def zero(self, now: float) -> None:
        """Send zero velocity once."""
        self.emit(Twist(now, 0.0, 0.0))

    def emit(self, *events: Event) -> None:
        """Hand events to all receivers, whatever one raises; raises the first error afterward.

        Raises:
            RobotError: this process was forked from the one that drives.
        """
        if self.is_forked:
            raise RobotError(
                "a forked process does not drive by the controller of the one that it comes from",
                "make a voz.Controller of its own there",
            )
        errors: list[BaseException] = []
        for event in events:
            for receive in self.receivers:
                try:
                    with ends_forks():
                        receive(event)
                except BaseException as error:  # zero has to reach those behind it
                    errors.append(error)
        if errors:
            raise errors[0]

    @property
    def is_forked(self) -> bool:
        """Whether this process was forked from the one that drives."""
        return os.getpid() != self._process


def is_time(now: float) -> bool:
    """Whether this can be a time of a run, s."""
    return is_finite(now) and abs(now) <= MAX_TIME


def check_time(now: float) -> None:
    """Raise ConfigError for what is no time of a run, s."""
    if not is_time(now):
        raise ConfigError(f"the time of the run is {shown_value(now)}; give seconds")


MAX_QUEUED_EVENTS = 6000
"""Waiting for a slow disk or reader: ten minutes of events."""

EVENT_FLUSH_TIMEOUT = 3.0
"""To write what waits when the run is over, s; some readers never read it."""


class QueuedReceiver:
    """Hands events to a receiver that may be slow, without waiting for it.

    The `with` block opens the receiver; its end writes what is queued and closes it. An error of
    the receiver ends the run; if the run is over already, the block raises it.
    """

    def __init__(
        self,
        name: str,
        opening: AbstractContextManager[Receiver],
        report: Callable[[Notice | End], None],
    ) -> None:
        """Prepare a queue for a receiver that is opened and left on the other thread.

        `report` takes the warning that it is too slow, and the end of the run by an error; messages
        name what is written.
        """
        self._name = name
        self._opening = opening
        self._report = report
        self._waiting: queue.Queue[Event | None] = queue.Queue(MAX_QUEUED_EVENTS)
        self._opened = threading.Event()
        self._failure: Exception | None = None
        self._warned = False
        self._thread = threading.Thread(target=self._work, name="voz-queued", daemon=True)

    def __enter__(self) -> Receiver:
        """Open the receiver; raises what that raises."""
        self._thread.start()
        self._opened.wait()
        if self._failure:
            raise self._failure
        return self._receive

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if not self._failure:
            with suppress(queue.Full):
                self._waiting.put(None, timeout=EVENT_FLUSH_TIMEOUT)
                self._thread.join(EVENT_FLUSH_TIMEOUT)
        if kind is None and self._failure:
            raise self._failure

    def _receive(self, event: Event) -> None:
        try:
            self._waiting.put_nowait(event)
        except queue.Full:
            if not self._warned and not self._failure:
                self._warned = True
                text = f"{self._name}: cannot be written fast enough; events are missing"
                self._report(Notice(event.t, text))

    def _work(self) -> None:
        try:
            with self._opening as write:
                self._opened.set()
                while (event := self._waiting.get()) is not None:
                    write(event)
        except BaseException as error:  # it ends the run, which sends the events
            self._failure = error if isinstance(error, Exception) else RuntimeError(repr(error))
            if self._opened.is_set():
                self._report(End(self._failure))
        finally:
            self._opened.set()
