"""Applies the controller's steps, and hands the events to all receivers."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence

from voz.control.bounded_motion import Place
from voz.control.controller import ControllerState, halted, step
from voz.control.messages import Beat, ControllerMessage, Halt, StopMotion
from voz.errors import ConfigError, RobotError
from voz.events import Event, Partial, Receiver, Twist, Utterance
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
