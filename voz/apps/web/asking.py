"""Asks the control loop for something, and knows when it was done: not sent, but done."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeVar

from voz.control.table import STOP
from voz.events import Event, Twist, Utterance
from voz.inbox import Halt, Inbox
from voz.language.sentences.command_set import Commands
from voz.language.sentences.spelling import normalize
from voz.run.sources import LONGEST, typed

Kind = TypeVar("Kind")

PAGE = "page"
"""The source of a command that was given on a page, or by a program that uses its API."""

BY_PAGE = "stopped from the operator page"

PATIENCE = 1.0
"""For the control loop to do it, s; it takes a tenth of that."""

LEAST = 0.0001
"""Between the times of two commands, s, which tell them apart."""


class NotDone(Exception):
    """The control loop did not answer in time."""


class Asking:
    """Puts commands into the inbox, and waits until they come back as events.

    It is used on the server's thread; only the inbox is shared.
    """

    def __init__(
        self, inbox: Inbox, clock: Callable[[], float], known: Callable[[], Commands]
    ) -> None:
        """Prepare to ask.

        Args:
            inbox: where commands go.
            clock: the time of the run, s.
            known: tells what may be asked for now; any other text is not accepted.
        """
        self._inbox = inbox
        self._clock = clock
        self._known = known
        self._last = 0.0
        self._commands: dict[float, asyncio.Future[Utterance]] = {}  # by their times
        self._stops: dict[float, asyncio.Future[float]] = {}
        self._obeyed: list[asyncio.Future[float]] = []  # of them; zero velocity is yet to be sent

    async def command(self, text: str) -> Utterance:
        """Ask for a command; gives what became of it, or raises NotDone."""
        text = normalize(text[:LONGEST])
        t = self._time()
        self._commands[t] = asyncio.get_running_loop().create_future()
        self._inbox.put(typed(text, self._known(), t, PAGE))
        return await _answer(self._commands, t)

    async def stop(self) -> float:
        """Stop the robot; gives the time of the zero velocity that was sent for it, or NotDone."""
        t = self._time()
        self._stops[t] = asyncio.get_running_loop().create_future()
        self._inbox.put(Utterance(t, STOP, 1.0, True, t, t, PAGE))
        self._inbox.put(Halt(BY_PAGE, t))  # the bare rules obey `stop` only while listening
        return await _answer(self._stops, t)

    def halt(self) -> None:
        """Let the robot stand still, without an answer."""
        self._inbox.put(Halt(BY_PAGE, self._time()))

    def take(self, event: Event) -> None:
        """Look whether an event is what somebody waits for."""
        if isinstance(event, Utterance) and event.source == PAGE:
            if event.t in self._commands and not (command := self._commands[event.t]).done():
                command.set_result(event)
            elif event.t in self._stops:
                self._obeyed.append(self._stops[event.t])
        elif isinstance(event, Twist) and not (event.linear or event.angular):
            for stopped in self._obeyed:
                if not stopped.done():
                    stopped.set_result(event.t)
            self._obeyed.clear()

    def _time(self) -> float:
        """What time it is: another for each command, by which it is known when it comes back."""
        self._last = round(max(self._last + LEAST, self._clock()), 4)
        return self._last


async def _answer(asked: dict[float, asyncio.Future[Kind]], t: float) -> Kind:
    try:
        return await asyncio.wait_for(asked[t], PATIENCE)
    except asyncio.TimeoutError:
        raise NotDone from None
    finally:
        del asked[t]
