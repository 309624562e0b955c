"""Answers a Wyoming client that gives commands as text, as Home Assistant does.

A `transcript` is obeyed: `handled`, `not-handled` or `not-recognized`. A `recognize` moves nothing:
`intent` or `not-recognized`. Home Assistant would try to handle an `intent` by itself, so that it
is no answer to a `transcript`.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any

from wyoming.asr import Transcript
from wyoming.event import Event, Eventable
from wyoming.handle import Handled, NotHandled
from wyoming.info import (
    Describe,
    HandleModel,
    HandleProgram,
    Info,
    IntentModel,
    IntentProgram,
)
from wyoming.intent import Entity, Intent, NotRecognized, Recognize

from voz import __version__
from voz.apps.servers.connections import ConnectionGuard, network_of
from voz.apps.servers.rate_limits import RateLimit
from voz.apps.wyoming.connection import ATTRIBUTION, Connection
from voz.apps.wyoming.given_commands import WYOMING_SOURCE, CommandOutcome, GivenCommands
from voz.errors import RobotError
from voz.events import explain_not_obeyed
from voz.inbox import Inbox
from voz.language.sentences.command_set import Commands, Parse
from voz.run.sources import parsed_utterance, read_text

COMMAND_RATE, COMMAND_BURST = 10.0, 20.0
"""Commands per second, and at once, of all clients; those that stop the robot are not counted.

What is not obeyed counts too: to find the command that is nearest to a text takes up to 65 ms.
"""

TOO_MANY = "too many commands"

PAGE_DRIVES = "somebody drives the robot from the operator page"

Context = dict[str, Any] | None
"""What a client wants back with the answer."""


@dataclass(frozen=True)
class RobotAccess:
    """What the clients of a run share.

    Attributes:
        given: passes commands on.
        inbox: knows which of them stop the robot.
        commands: returns what may be said now.
        language: its code, as `en`.
        page_drives: returns whether somebody drives from the operator page.
        limit: of the commands of all clients.
        event_limit_of: returns the limit of all events from a network.
    """

    given: GivenCommands
    inbox: Inbox
    commands: Callable[[], Commands]
    language: str
    page_drives: Callable[[], bool]
    limit: RateLimit
    event_limit_of: Callable[[Hashable], RateLimit]


class CommandHandler(Connection):
    """Answers one client."""

    max_bytes = 64_000

    def __init__(
        self,
        robot: RobotAccess,
        guard: ConnectionGuard,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
    ) -> None:
        super().__init__(guard, reader, writer)
        self._robot = robot

    async def answer(self, event: Event) -> None:
        """Obey a `transcript`, understand a `recognize`, and answer `describe`."""
        robot = self._robot
        answer: Eventable | None = None
        transcript = Transcript.from_event(event) if Transcript.is_type(event.type) else None
        parse = self._read(transcript.text) if transcript else None
        stops = parse is not None and parse.command in robot.inbox.halts
        if not stops and not robot.event_limit_of(network_of(self.peer)).allows(time.monotonic()):
            raise RobotError("too many events")
        if transcript and parse and not stops and robot.page_drives():
            answer = NotHandled(PAGE_DRIVES, transcript.context)
        elif transcript:
            answer = await self._obey(transcript.text, stops, transcript.context)
        elif Describe.is_type(event.type):
            answer = _info(robot.commands(), robot.language)
        elif Recognize.is_type(event.type):
            recognize = Recognize.from_event(event)
            answer = self._recognize(recognize.text, recognize.context)
        if answer:
            await self.write_event(answer.event())

    async def _obey(self, text: str, stops: bool, context: Context) -> Eventable:
        if not stops and not self._robot.limit.allows(time.monotonic()):
            return NotHandled(TOO_MANY, context)
        try:
            return _answer(await self._robot.given.give(text), context)
        except RobotError as late:
            return NotHandled(str(late), context)

    def _recognize(self, text: str, context: Context) -> Eventable:
        if not self._robot.limit.allows(time.monotonic()):
            return NotRecognized(TOO_MANY, context)
        parse = self._read(text)
        if parse is None:
            unknown = parsed_utterance(text, None, self._robot.commands(), 0.0, WYOMING_SOURCE)
            return NotRecognized(explain_not_obeyed(unknown), context)
        entities = [Entity(name, value) for name, value in parse.slots.items()]
        return Intent(parse.command, entities, context=context)

    def _read(self, text: str) -> Parse | None:
        return read_text(text, self._robot.commands(), self._robot.inbox.halts)


def _answer(outcome: CommandOutcome, context: Context) -> Eventable:
    """What was said is the answer where the robot says nothing."""
    utterance = outcome.utterance
    if utterance.obeyed:
        return Handled(" ".join(outcome.replies) or utterance.text, context)
    why = "; ".join(outcome.problems) or explain_not_obeyed(utterance)
    return (NotHandled if utterance.accepted else NotRecognized)(why, context)


def _info(commands: Commands, language: str) -> Info:
    """Describe this server to a client."""
    said = ", ".join(commands.named(commands.names, 1)[:20])
    about: dict[str, Any] = {
        "attribution": ATTRIBUTION,
        "installed": True,
        "version": __version__,
        "description": f"Drives a robot: {said}",
    }
    model = {**about, "name": "commands", "languages": [language]}
    program = {**about, "name": "voz robot"}
    return Info(
        handle=[HandleProgram(**program, models=[HandleModel(**model)])],
        intent=[IntentProgram(**program, models=[IntentModel(**model)])],
    )
