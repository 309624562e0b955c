"""Passes commands from the server to the control loop, and waits until they were obeyed."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeVar

from voz.control.messages import Halt
from voz.control.table import STOP
from voz.errors import RobotError
from voz.events import Event, Twist, Utterance
from voz.inbox import Inbox
from voz.language.sentences.command_set import Commands, Parse
from voz.run.sources import read_text, text_utterance

Answer = TypeVar("Answer")

PAGE_SOURCE = "page"
"""The source of a command of the page that drives, or of a program that is watched like one."""

PROGRAM_SOURCE = "program"
"""The source of a command that was posted while no page drives: nobody knows whether its sender is
still there."""

STOPPED_BY_PAGE = "stopped from the operator page"

COMMAND_TIMEOUT = 1.0
"""For the control loop to answer, s; it takes a tenth of that."""

MIN_TIME_STEP = 0.0001
"""Between the times of two commands, s, by which their answers are told apart."""


class CommandBridge:
    """Puts commands into the inbox, and waits until they come back as events.

    Event-loop thread only; the inbox alone is shared.
    """

    def __init__(
        self, inbox: Inbox, clock: Callable[[], float], known: Callable[[], Commands]
    ) -> None:
        """Connect to a run; text that is none of the `known` commands is not accepted."""
        self._inbox = inbox
        self._clock = clock
        self._known = known
        self._last_time = 0.0
        self._commands: dict[float, asyncio.Future[Utterance]] = {}  # by their times
        self._stops: dict[float, asyncio.Future[float]] = {}
        self._obeyed: list[asyncio.Future[float]] = []  # stops that await zero velocity

    def sentence(self, answer: str) -> str | None:
        """The text that gives an answer, a sentence or a command's name; None if none does."""
        if self._read(answer):
            return answer
        return next(iter(self._known().named([answer], 1)), None)

    async def command(self, text: str, source: str) -> Utterance:
        """Give a command; returns what became of it; raises RobotError without an answer."""
        t = self._unique_time()
        self._commands[t] = asyncio.get_running_loop().create_future()
        self._inbox.put(text_utterance(text, self._known(), self._inbox.halts, t, source))
        return await _answer(self._commands, t)

    def stops(self, text: str) -> bool:
        """Whether a text stops the robot."""
        parse = self._read(text)
        return parse is not None and parse.command in self._inbox.halts

    def _read(self, text: str) -> Parse | None:
        return read_text(text, self._known(), self._inbox.halts)

    async def stop(self) -> float:
        """Stop the robot; returns when it stood, s; raises RobotError without an answer."""
        t = self._unique_time()
        self._stops[t] = asyncio.get_running_loop().create_future()
        self._inbox.put(Utterance(t, STOP, 1.0, True, t, t, PAGE_SOURCE))
        self._inbox.put(Halt(STOPPED_BY_PAGE, t))  # without S1 `stop` works only while listening
        return await _answer(self._stops, t)

    def halt(self) -> None:
        """Stop the robot without waiting for an answer."""
        self._inbox.put(Halt(STOPPED_BY_PAGE, self._unique_time()))

    def receive(self, event: Event) -> None:
        """Take an event of the run, which may answer a command."""
        if isinstance(event, Utterance) and event.source in (PAGE_SOURCE, PROGRAM_SOURCE):
            if event.t in self._commands and not (command := self._commands[event.t]).done():
                command.set_result(event)
            elif event.t in self._stops:
                self._obeyed.append(self._stops[event.t])
        elif isinstance(event, Twist) and not (event.linear or event.angular):
            for stopped in self._obeyed:
                if not stopped.done():
                    stopped.set_result(event.t)
            self._obeyed.clear()

    def _unique_time(self) -> float:
        """The time, later than that of any command before."""
        self._last_time = round(max(self._last_time + MIN_TIME_STEP, self._clock()), 4)
        return self._last_time


async def _answer(awaited: dict[float, asyncio.Future[Answer]], t: float) -> Answer:
    try:
        return await asyncio.wait_for(awaited[t], COMMAND_TIMEOUT)
    except asyncio.TimeoutError:
        raise RobotError("the control loop does not answer") from None
    finally:
        del awaited[t]
