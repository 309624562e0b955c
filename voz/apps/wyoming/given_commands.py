"""Passes commands of a Wyoming server to the control loop, and collects what came of each."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from voz.errors import RobotError
from voz.events import Event, Notice, Reply, Twist, Utterance
from voz.inbox import Inbox
from voz.language.sentences.command_set import Commands
from voz.run.sources import text_utterance

WYOMING_SOURCE = "wyoming"
"""The source of a command that was given there."""

COMMAND_TIMEOUT = 1.0
"""For the control loop to answer, s; it takes a tenth of that."""

MIN_TIME_STEP = 0.0001
"""Between the times of two commands, s, by which their answers are told apart."""


@dataclass(frozen=True)
class CommandOutcome:
    """What became of a command: the utterance, the replies, and why it could not be done."""

    utterance: Utterance
    replies: tuple[str, ...]
    problems: tuple[str, ...]


class GivenCommands:
    """Gives commands on an event loop's thread, and takes events on that of the control loop."""

    def __init__(
        self, inbox: Inbox, clock: Callable[[], float], known: Callable[[], Commands]
    ) -> None:
        """Connect to a run; text that is none of the `known` commands is not accepted."""
        self._inbox = inbox
        self._clock = clock
        self._known = known
        self._last_time = 0.0
        self._awaited: dict[
            float, asyncio.Future[CommandOutcome]
        ] = {}  # by the times of the commands
        self._events: list[Event] = []  # of the command that takes effect now, itself first
        self._loop: asyncio.AbstractEventLoop | None = None

    async def give(self, text: str) -> CommandOutcome:
        """Give a command; returns what became of it; raises RobotError without an answer.

        Of a command that stops the robot the answer comes when zero velocity was sent.
        """
        self._loop = asyncio.get_running_loop()
        self._last_time = t = round(max(self._last_time + MIN_TIME_STEP, self._clock()), 4)
        self._awaited[t] = self._loop.create_future()
        halts = self._inbox.halts
        self._inbox.put(text_utterance(text, self._known(), halts, t, WYOMING_SOURCE))
        try:
            return await asyncio.wait_for(self._awaited[t], COMMAND_TIMEOUT)
        except asyncio.TimeoutError:
            raise RobotError("the control loop does not answer") from None
        finally:
            del self._awaited[t]

    def receive(self, event: Event) -> None:
        """Take an event of the run; a command is over at the next one or the next velocity."""
        if isinstance(event, Utterance):
            self._finish()
            self._events = [event] if event.source == WYOMING_SOURCE else []
        elif isinstance(event, Twist):
            self._finish()
        elif self._events:
            self._events.append(event)

    def _finish(self) -> None:
        """Hand what became of a command to the thread that waits for it."""
        events, self._events = self._events, []
        if not events or self._loop is None:
            return
        given = events[0]
        assert isinstance(given, Utterance)
        of_it = [event for event in events if event.t == given.t]
        outcome = CommandOutcome(
            given,
            tuple(event.text for event in of_it if isinstance(event, Reply)),
            tuple(event.text for event in of_it if isinstance(event, Notice)),
        )
        with suppress(RuntimeError):  # the server has ended
            self._loop.call_soon_threadsafe(self._settle, outcome)

    def _settle(self, outcome: CommandOutcome) -> None:
        awaited = self._awaited.get(outcome.utterance.t)
        if awaited and not awaited.done():
            awaited.set_result(outcome)
