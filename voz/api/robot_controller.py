"""Drives a robot by a microphone or by utterances, in a program of one's own."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from threading import Thread
from typing import Any

import msgspec

from voz.api.recognizer import MicrophoneUtterances
from voz.config import Config, default_commands, with_usual_names
from voz.control.controller import ControllerState, Rules, change_rules
from voz.control.messages import Beat, End, StopMotion, too_late
from voz.control.motion import Place
from voz.control.state_machine import State
from voz.control.table import CommandTable
from voz.errors import ConfigError
from voz.events import Partial, Receiver, Utterance, shift_time
from voz.hearing.microphone_thread import Hearing, sound_card
from voz.inbox import Inbox
from voz.records import check_callable, check_iterable, check_type
from voz.robot.base import Robot, check_receives
from voz.robot.factory import odometry_of, open_mailboxes
from voz.run.clocks import Clock
from voz.run.command_check import begins_listening, check_list, matched_settings
from voz.run.dispatcher import Dispatcher, check_time, is_time
from voz.run.parts import answer_receiver
from voz.run.session import Session
from voz.run.spec import RunSpec
from voz.settings import Safety

_log = logging.getLogger("voz")

ROBOT = "robot"
"""Name of the robot in messages."""


class RobotController(Dispatcher):
    """Obeys commands and sends velocities to a robot.

        with voz.Controller(robot, safety=voz.Safety(max_linear=0.2)) as controller:
            controller.run(recognizer.microphone())

    `run` is all that a microphone needs. In a loop of one's own, `hear` takes what was heard and
    `send` sends the velocities, 10 times a second; time comes in with each call. Replies are events
    for the robot; nothing is spoken.
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
        receivers = [] if isinstance(robot, Robot) else robot
        super().__init__(ControllerState(rules, State(listening=listening)), receivers, odometry)
        self._robot = robot if isinstance(robot, Robot) else None
        self._opened = ExitStack()
        self._now = 0.0  # the time of the run that was reached, s

    def __enter__(self) -> RobotController:
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
            self._opened.pop_all()  # the process that it comes from stops the robot and closes it
            return
        with self._opened:
            self.halt()
            self.zero(self._now)

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
        check_time(now)
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

    def zero(self, now: float) -> None:
        """Send zero velocity once, at a time of the run, s; ConfigError afterward if it is none."""
        super().zero(now if is_time(now) else self._now)
        check_time(now)

    def run(self, heard: MicrophoneUtterances | Iterable[Utterance | Partial]) -> None:
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
        self, session: Session, heard: MicrophoneUtterances | Iterable[Utterance | Partial]
    ) -> Iterator[None]:
        """Let a run hear, and watch the robot."""
        inbox, clock = session.inbox, session.clock
        if self._robot:
            session.watch(ROBOT, self._lost)
        if isinstance(heard, MicrophoneUtterances):
            with self._hearing(heard, inbox, clock) as hearing:
                session.watch_input(hearing)
                session.receivers.append(answer_receiver(heard.recognizer))
                yield
        else:
            Thread(target=_forward, args=(heard, inbox, clock), daemon=True).start()
            yield

    def _hearing(self, heard: MicrophoneUtterances, inbox: Inbox, clock: Clock) -> Hearing:
        heard.close()  # it is opened again after each loss
        recognizer = heard.recognizer
        self.state = change_rules(self.state, name=recognizer.name, ask=recognizer.ask)
        if self._own:
            own = matched_settings(self._own, recognizer.commands)
            self.state = change_rules(self.state, table=own.table)
        table = self.state.rules.table
        check_list(recognizer.commands, table, "the list")
        if not self.listening and not begins_listening(recognizer.commands, table):
            names = " or ".join(f'"{name}"' for name in sorted(table.starts))
            raise ConfigError(
                f"no command begins the listening; add {names} to the list, or give listening=True"
            )
        source = sound_card(heard.device)
        return Hearing(recognizer, source, inbox, clock.now, never_missed=table.stops)


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


def _forward(heard: Iterable[Utterance | Partial], inbox: Inbox, clock: Clock) -> None:
    """Put what is heard into an inbox, in the time of the run, and its end."""
    try:
        for event in heard:
            check_type((Utterance, Partial), event, "heard")
            inbox.put(shift_time(event, clock.now() - event.t))
    except BaseException as error:  # `sys.exit` and a cancelled task, too: nobody commands any more
        inbox.put(End(error))
    else:
        while not inbox.is_empty:  # the end would overtake what was heard
            time.sleep(0.01)
        inbox.put(End())
