"""Passes commands from a server to the control loop, and events back to the server."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from voz.control.messages import Halt
from voz.control.table import STOP
from voz.errors import RobotError
from voz.events import Event, Notice, Reply, Twist, Utterance
from voz.inbox import Inbox
from voz.language.sentences.command_set import Commands, Parse
from voz.run.sources import read_text, text_utterance

COMMAND_TIMEOUT = 1.0
"""For the control loop to answer, s; it takes a tenth of that."""

MIN_TIME_STEP = 0.0001
"""Between the times of two commands, s, by which their answers are told apart."""

MAX_QUEUED_EVENTS = 2000
"""Events that wait for a slow server; then the oldest are dropped."""


@dataclass(frozen=True)
class CommandOutcome:
    """What became of a command: the utterance, the replies, and why it could not be done."""

    utterance: Utterance
    replies: tuple[str, ...]
    problems: tuple[str, ...]


Until: TypeAlias = Literal["utterance", "outcome", "rest"]
"""What the sender of a command waits for."""


@dataclass(frozen=True)
class _Awaited:
    """A command, by its source, and what its sender waits for."""

    source: str
    until: Until
    answer: asyncio.Future[Any]

    def settle(self, answer: object) -> None:
        if not self.answer.done():  # else the sender waits no more
            self.answer.set_result(answer)


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
        self._awaited: dict[float, _Awaited] = {}  # by the times of the commands
        self._stops: list[_Awaited] = []  # obeyed; they await zero velocity
        self._current: _Awaited | None = None  # takes effect now
        self._events: list[Event] = []  # of the current one, its utterance first

    def read(self, text: str) -> Parse | None:
        """The command that a text is; None if it is none."""
        return read_text(text, self._known(), self._inbox.halts)

    def stops(self, parse: Parse | None) -> bool:
        """Whether what was read stops the robot."""
        return parse is not None and parse.command in self._inbox.halts

    def sentence(self, answer: str) -> str | None:
        """The text that gives an answer, a sentence or a command's name; None if none does."""
        if self.read(answer):
            return answer
        return next(iter(self._known().named([answer], 1)), None)

    async def command(self, text: str, source: str) -> Utterance:
        """Give a command; returns its utterance; raises RobotError without an answer."""
        utterance: Utterance = await self._answer(self._give(text, source), source, "utterance")
        return utterance

    async def carry_out(self, text: str, source: str) -> CommandOutcome:
        """Give a command; returns what became of it; raises RobotError without an answer.

        Of a command that stops the robot the answer comes when zero velocity was sent.
        """
        outcome: CommandOutcome = await self._answer(self._give(text, source), source, "outcome")
        return outcome

    async def stop(self, source: str, why: str) -> float:
        """Stop the robot; returns when it stood, s; raises RobotError without an answer."""
        t = self._unique_time()
        self._inbox.put(Utterance(t, STOP, 1.0, True, t, t, source))
        self._inbox.put(Halt(why, t))  # without S1 `stop` works only while listening
        stood: float = await self._answer(t, source, "rest")
        return stood

    def halt(self, why: str) -> None:
        """Stop the robot without waiting for an answer."""
        self._inbox.put(Halt(why, self._unique_time()))

    def receive(self, event: Event) -> None:
        """Take an event of the run, which may answer a command.

        The outcome of a command is complete at the next utterance or velocity.
        """
        if isinstance(event, Utterance | Twist):
            self._finish()
        if isinstance(event, Utterance):
            awaited = self._awaited.get(event.t)
            if awaited and awaited.source == event.source:
                self._take(awaited, event)
        elif isinstance(event, Twist):
            if not (event.linear or event.angular):
                for stop in self._stops:
                    stop.settle(event.t)
                self._stops.clear()
        elif self._current:
            self._events.append(event)

    def _take(self, awaited: _Awaited, utterance: Utterance) -> None:
        if awaited.until == "utterance":
            awaited.settle(utterance)
        elif awaited.until == "rest":
            self._stops.append(awaited)
        else:
            self._current, self._events = awaited, [utterance]

    def _finish(self) -> None:
        """Answer the command that took effect until now."""
        current, self._current = self._current, None
        if current is None:
            return
        utterance = self._events[0]
        assert isinstance(utterance, Utterance)
        of_it = [event for event in self._events if event.t == utterance.t]
        replies = tuple(event.text for event in of_it if isinstance(event, Reply))
        problems = tuple(event.text for event in of_it if isinstance(event, Notice))
        current.settle(CommandOutcome(utterance, replies, problems))

    def _give(self, text: str, source: str) -> float:
        t = self._unique_time()
        self._inbox.put(text_utterance(text, self._known(), self._inbox.halts, t, source))
        return t

    def _unique_time(self) -> float:
        """The time, later than that of any command before."""
        self._last_time = round(max(self._last_time + MIN_TIME_STEP, self._clock()), 4)
        return self._last_time

    async def _answer(self, t: float, source: str, until: Until) -> Any:
        answer: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._awaited[t] = _Awaited(source, until, answer)
        try:
            return await asyncio.wait_for(answer, COMMAND_TIMEOUT)
        except asyncio.TimeoutError:
            raise RobotError("the control loop does not answer") from None
        finally:
            del self._awaited[t]


class EventQueue:
    """A bounded queue from the thread of the control loop to the server's event loop."""

    def __init__(self) -> None:
        self._waiting: deque[Event] = deque(maxlen=MAX_QUEUED_EVENTS)
        self._loop: asyncio.AbstractEventLoop | None = None
        self._available = asyncio.Event()

    def receive(self, event: Event) -> None:
        """Take an event, from the control loop's thread; it never waits."""
        self._waiting.append(event)
        loop = self._loop
        if loop and not self._available.is_set():
            with suppress(RuntimeError):  # the server has ended
                loop.call_soon_threadsafe(self._available.set)

    async def events(self) -> AsyncIterator[Event]:
        """Yield the events as they come, on the server's thread, without end."""
        self._loop = asyncio.get_running_loop()
        while True:
            self._available.clear()
            while self._waiting:
                yield self._waiting.popleft()
            await self._available.wait()
