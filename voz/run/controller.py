"""The controller: the pure one of `voz.control` with its state, its clock and its receivers."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import msgspec

from voz.config import Config, default_commands, with_usual_names
from voz.control.controller import ControllerState, Rules, change_rules, halted, step
from voz.control.messages import Beat, ControllerMessage, Halt, StopMotion, too_late
from voz.control.motion import Place
from voz.control.state_machine import State
from voz.control.table import CommandTable
from voz.errors import ConfigError, RobotError
from voz.events import Event, Partial, Receiver, Twist, Utterance
from voz.printable import shown_value
from voz.process.forks import ends_forks
from voz.records import PublicNames, check_callable, check_iterable, check_type, is_finite
from voz.robot.base import Robot, check_receives
from voz.robot.factory import odometry_of, open_mailboxes
from voz.run.command_check import check_beginning, check_list, matched_settings
from voz.run.parts import take_utterances
from voz.run.session import Session
from voz.run.spec import RunSpec
from voz.settings import Safety
from voz.texts import language_of

if TYPE_CHECKING:
    from voz.recognition.engine import RecognitionEngine

_log = logging.getLogger("voz")

ROBOT = "robot"
"""Name of the robot in messages."""

MAX_TIME = 1e12
"""Of a run, s; events hold no later time."""


@runtime_checkable
class OpenedMicrophone(Protocol):
    """A microphone of a program, which a run opens again after each loss."""

    recognizer: RecognitionEngine

    def close(self) -> None:
        """Close it."""

    def drive_session(self, session: Session) -> AbstractContextManager[None]:
        """Let it drive a run for a `with` block."""


class Controller(PublicNames):
    """Obeys commands and sends velocities to a robot.

        with voz.Controller(robot, safety=voz.Safety(max_linear=0.2)) as controller:
            controller.run(recognizer.microphone())

    `run` is all that a microphone needs. In a loop of one's own, `hear` takes what was heard and
    `send` sends the velocities, 10 times a second; time comes in with each call. Replies are events
    for the robot; nothing is spoken.

    Attributes:
        state: of the controller; other threads may read it.
        receivers: called with every event, in order; none of them may wait for anything.
        odometry: returns where the robot is at a time of the run, s, without waiting.
    """

    def __init__(
        self,
        robot: Robot | Sequence[Receiver],
        safety: Safety | None = None,
        listening: bool = False,
        table: CommandTable | None = None,
        odometry: Callable[[float], Place | None] = lambda _: None,
        *,
        commands: Mapping[str, Any] | None = None,
    ) -> None:
        """Start with the robot at rest.

        Args:
            robot: the robot, opened by the `with` block; or functions that are called with every
                event, in order, and must not wait for anything.
            safety: the safety rules' settings; None takes the defaults.
            listening: whether commands are obeyed before a `start speech`.
            table: what each command does; None takes `commands`.
            odometry: returns where the robot is at a time of the run, s, without waiting.
            commands: what each command does, as `[commands]` in voz.toml: beside or in place of
                what voz's own do.

        Raises:
            ConfigError: an argument is something else, or the robot might not stop.
        """
        _check_robot(robot)
        check_type((Safety, type(None)), safety, "safety")
        check_type((CommandTable, type(None)), table, "table")
        check_callable(odometry, "odometry")
        check_type(bool, listening, "listening")
        self._own = None if table else _settings(commands)
        own = self._own.table if self._own else default_commands()
        rules = Rules(table or own, safety or Safety())
        self.state = ControllerState(rules, State(listening=listening))
        self.receivers = [] if isinstance(robot, Robot) else [*robot]
        self.odometry = odometry
        self._robot = robot if isinstance(robot, Robot) else None
        self._opened = ExitStack()
        self._now = 0.0  # the time of the run that was reached, s
        self._process = os.getpid()

    def __enter__(self) -> Controller:
        """Open the robot; raises RobotError if it cannot be reached."""
        if self._robot:
            boxes = self._opened.enter_context(open_mailboxes({ROBOT: self._robot}, _log.error))
            receive = boxes[ROBOT].receive
            self.receivers.append(receive)
            self._opened.callback(self.receivers.remove, receive)
            self._lost = boxes[ROBOT].lost
            self.odometry = odometry_of({ROBOT: self._robot})
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the robot and close it; raises what a receiver raises, after that."""
        if self.is_forked:
            return  # the process that it comes from stops the robot and closes it
        with self._opened:
            self.halt()
            self.zero(self._now)

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

    def hear(self, event: Utterance | Partial, late: bool = False) -> None:
        """Obey an utterance if it is accepted; halt at what may be a command that stops.

        Args:
            event: what was heard.
            late: whether it is out of date; then it can move nothing.

        Raises:
            ConfigError: an argument is something else.
        """
        check_type((Utterance, Partial), event, "event")
        check_type(bool, late, "late")
        self.take(too_late(event) if late else event, event.t)

    def send(self, now: float) -> None:
        """Let time pass until `now`, s of the run, and send the velocities once.

        Raises:
            ConfigError: the time is no number.
            RobotError: this process was forked from the one that drives.
        """
        _check_time(now)
        self._now = now
        self.take(Beat(), now)

    def stop(self, now: float, why: str) -> None:
        """End the motion until a new command.

        Args:
            now: the time of the run, s.
            why: for people; receivers get it as a `Notice`.

        Raises:
            ConfigError: the time is no number; the motion is ended all the same.
        """
        self.take(StopMotion(why), now)

    def halt(self) -> None:
        """Ask the robot to stand still from now on."""
        self.state = halted(self.state)

    def zero(self, now: float) -> None:
        """Send zero velocity once, at a time of the run, s; ConfigError afterward if it is none."""
        self.emit(Twist(now if _is_time(now) else self._now, 0.0, 0.0))
        _check_time(now)

    def run(self, heard: OpenedMicrophone | Iterable[Utterance | Partial]) -> None:
        """Drive in real time, 10 times a second, until what is heard ends; then stop the robot.

        A microphone that is lost stops the robot, and is opened again when it is back. Where
        utterances come from an iterable, it waits for them on a thread of its own; when it ends,
        the robot stops.

        Args:
            heard: what `recognizer.microphone()` returns, or utterances as they are said.

        Raises:
            AudioError: there is no such microphone.
            ConfigError: the list of commands can move the robot and not stop it, or cannot begin,
                or something else is heard.
        """
        check_iterable(heard, "heard")
        if self._robot and not self.receivers:
            raise ConfigError("the robot is not open; use `with voz.Controller(...)`")
        session = Session(RunSpec(controller=self, parts=[partial(self._connect, heard=heard)]))
        try:
            session.run()
        finally:
            self._now = session.clock.now()

    @contextmanager
    def _connect(
        self, session: Session, heard: OpenedMicrophone | Iterable[Utterance | Partial]
    ) -> Iterator[None]:
        """Watch the robot, and let a run hear."""
        if self._robot:
            session.watch(ROBOT, self._lost)
        if isinstance(heard, OpenedMicrophone):
            heard.close()  # it is opened again after each loss
            self._take_list(heard.recognizer)
            opening = heard.drive_session(session)
        else:
            opening = take_utterances(session, heard)
        with opening:
            yield

    def _take_list(self, recognizer: RecognitionEngine) -> None:
        """Obey a recognizer's list of commands, and the robot's name."""
        commands = recognizer.commands
        self.state = change_rules(self.state, name=recognizer.name, ask=recognizer.ask)
        if self._own:
            own = matched_settings(self._own, commands)
            self.state = change_rules(self.state, table=own.table)
        table = self.state.rules.table
        check_list(commands, table, "the list")
        if not self.listening:
            check_beginning(commands, table, " to the list, or give listening=True")

    def take(self, message: ControllerMessage, now: float) -> None:
        """Let a message take effect at a time of the run, s, and hand on what comes of it.

        Raises:
            ConfigError: the time is no number; a stop ends the motion all the same.
        """
        if isinstance(message, Halt | StopMotion):
            self.halt()
        if not isinstance(message, Utterance | Partial):
            _check_time(now)
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


def controller_by(settings: Config, listening: bool = False) -> Controller:
    """Make the controller of a run by its settings; its receivers come with the robots."""
    controller = Controller([], settings.safety, listening, settings.table)
    recognition, language = settings.recognition, language_of(settings.language.name)
    controller.state = change_rules(
        controller.state, name=recognition.name, ask=recognition.ask, language=language
    )
    return controller


def _check_robot(robot: object) -> None:
    """Raise ConfigError for what is neither a robot nor receivers, as a class."""
    if isinstance(robot, type):
        raise ConfigError(f"{robot.__name__} is a class; give a robot, as {robot.__name__}()")
    if isinstance(robot, Robot):
        check_receives(robot)
        return
    check_type(Sequence, robot, "robot")
    for receiver in robot:  # type: ignore[attr-defined]
        check_callable(receiver, "robot")


def _settings(commands: Mapping[str, Any] | None) -> Config | None:
    """Settings with what the commands do; None for those of voz alone."""
    if commands is None:
        return None
    check_type(Mapping, commands, "commands")
    try:
        return with_usual_names(msgspec.convert({"commands": dict(commands)}, Config))
    except msgspec.ValidationError as error:
        raise ConfigError(f"commands: {error}", "docs/actions.md lists the steps") from error


def _is_time(now: float) -> bool:
    """Whether this can be a time of a run, s."""
    return is_finite(now) and abs(now) <= MAX_TIME


def _check_time(now: float) -> None:
    """Raise ConfigError for what is no time of a run, s."""
    if not _is_time(now):
        raise ConfigError(f"the time of the run is {shown_value(now)}; give seconds")
