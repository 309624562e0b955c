"""Takes commands for the robot of a run as text by the Wyoming protocol, as of Home Assistant.

A `transcript` is obeyed: `handled`, `not-handled` or `not-recognized`. A `recognize` moves nothing:
`intent` or `not-recognized`. Home Assistant would try to handle an `intent` by itself, so that it
is no answer to a `transcript`.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Hashable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

from wyoming.asr import Transcript
from wyoming.event import Event as ClientEvent
from wyoming.event import Eventable
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
from voz.apps.servers.command_bridge import CommandBridge, CommandOutcome, EventQueue
from voz.apps.servers.connections import (
    REQUEST_BURST,
    REQUEST_RATE,
    SERVER_SHUTDOWN_TIMEOUT,
    ConnectionGuard,
    RateLimit,
    network_of,
    rate_limit_per_client,
)
from voz.apps.wyoming.announcement import announced
from voz.apps.wyoming.connection import ATTRIBUTION, Connection, serving
from voz.errors import ConfigError, RobotError
from voz.events import Event, explain_not_obeyed
from voz.language.language_files import read_language_info
from voz.language.sentences.command_set import Commands, Parse
from voz.run.session import Session
from voz.run.sources import parsed_utterance
from voz.texts import language_of, translate

WYOMING_SOURCE = "wyoming"
"""The source of a command that was given there."""

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
    """What the clients of a run share."""

    bridge: CommandBridge  # passes commands on
    commands: Callable[[], Commands]  # returns what may be said now
    language: str  # its code, as `en`
    page_drives: Callable[[], bool]  # returns whether somebody drives from the operator page
    limit: RateLimit  # of the commands of all clients
    # Returns the limit of all events from a network.
    event_limit_of: Callable[[Hashable], RateLimit]

    @property
    def texts(self) -> str:
        """The language of what is answered: English where there are no texts in its own."""
        return language_of(self.language)


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

    async def answer(self, event: ClientEvent) -> None:
        """Obey a `transcript`, understand a `recognize`, and answer `describe`."""
        robot = self._robot
        answer: Eventable | None = None
        transcript = Transcript.from_event(event) if Transcript.is_type(event.type) else None
        parse = robot.bridge.read(transcript.text) if transcript else None
        stops = robot.bridge.stops(parse)
        if not stops and not robot.event_limit_of(network_of(self.peer)).allows(time.monotonic()):
            raise RobotError("too many events")
        if transcript:
            answer = await self._obey(transcript.text, parse, transcript.context)
        elif Describe.is_type(event.type):
            answer = _info(robot.commands(), robot.language)
        elif Recognize.is_type(event.type):
            recognize = Recognize.from_event(event)
            answer = self._recognize(recognize.text, recognize.context)
        if answer:
            await self.write_event(answer.event())

    async def _obey(self, text: str, parse: Parse | None, context: Context) -> Eventable:
        robot = self._robot
        stops = robot.bridge.stops(parse)
        if not stops and parse and robot.page_drives():
            return NotHandled(translate(PAGE_DRIVES, robot.texts), context)
        if not stops and not robot.limit.allows(time.monotonic()):
            return NotHandled(translate(TOO_MANY, robot.texts), context)
        try:
            outcome = await robot.bridge.carry_out(text, WYOMING_SOURCE)
        except RobotError as late:
            return NotHandled(translate(str(late), robot.texts), context)
        return _answer(outcome, robot.texts, context)

    def _recognize(self, text: str, context: Context) -> Eventable:
        if not self._robot.limit.allows(time.monotonic()):
            return NotRecognized(translate(TOO_MANY, self._robot.texts), context)
        parse = self._robot.bridge.read(text)
        if parse is None:
            unknown = parsed_utterance(text, None, self._robot.commands(), 0.0, WYOMING_SOURCE)
            return NotRecognized(explain_not_obeyed(unknown, self._robot.texts), context)
        entities = [Entity(name, value) for name, value in parse.slots.items()]
        return Intent(parse.command, entities, context=context)


def _answer(outcome: CommandOutcome, language: str, context: Context) -> Eventable:
    """What was said is the answer where the robot says nothing."""
    utterance = outcome.utterance
    problems = "; ".join(translate(problem, language) for problem in outcome.problems)
    if utterance.obeyed:
        return Handled(" ".join(outcome.replies) or problems or utterance.text, context)
    why = problems or explain_not_obeyed(utterance, language)
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


class RobotService:
    """Lets Wyoming clients drive the robot of a run."""

    source = WYOMING_SOURCE  # of the commands; who gives them does not watch the robot

    def __init__(
        self,
        session: Session,
        page_drives: Callable[[], bool],
        uri: str,
        *,
        announce: bool = True,
    ) -> None:
        """Prepare to serve at an address, `tcp://HOST:PORT` or `unix://FILE`.

        While `page_drives` is true, only commands that stop the robot are obeyed.
        """
        recognizer = session.recognizer
        assert recognizer

        def commands() -> Commands:
            return recognizer.commands

        language = read_language_info(recognizer.files).code
        self._uri = uri
        self._events = EventQueue()
        self._bridge = CommandBridge(session.inbox, session.clock.now, commands)
        self._robot = RobotAccess(
            self._bridge, commands, language, page_drives,
            limit=RateLimit(COMMAND_RATE, COMMAND_BURST),
            event_limit_of=rate_limit_per_client(REQUEST_RATE, REQUEST_BURST),
        )  # fmt: skip
        self._announce = announce
        self._warn = session.warn

    def receive(self, event: Event) -> None:
        """Take an event of the run; it never waits."""
        self._events.receive(event)

    @contextmanager
    def serving(self) -> Iterator[None]:
        """Serve for a `with` block; raises ConfigError if the address cannot be listened on."""
        started: Future[Callable[[], None]] = Future()
        thread = threading.Thread(
            target=self._work, args=(started,), name="voz-wyoming", daemon=True
        )
        thread.start()
        end = started.result()
        try:
            yield
        finally:
            end()
            thread.join(SERVER_SHUTDOWN_TIMEOUT)

    def _work(self, started: Future[Callable[[], None]]) -> None:
        try:
            asyncio.run(self._serve(started))
        except ConfigError as error:
            started.set_exception(error)
        except BaseException as error:  # whatever it is: the robot goes on
            self._warn(f"--wyoming {self._uri} has failed ({error!r})")

    async def _serve(self, started: Future[Callable[[], None]]) -> None:
        loop, ended = asyncio.get_running_loop(), asyncio.Event()

        def end() -> None:
            with suppress(RuntimeError):  # it has failed before
                loop.call_soon_threadsafe(ended.set)

        async with serving(self._uri, partial(CommandHandler, self._robot)):
            started.set_result(end)
            passing = asyncio.create_task(self._pass_events())
            passing.add_done_callback(lambda _: ended.set())  # it has no end of its own
            async with announced(self._uri, self._warn) if self._announce else nullcontext():
                await ended.wait()
            if passing.done():
                passing.result()
            passing.cancel()

    async def _pass_events(self) -> None:
        async for event in self._events.events():
            self._bridge.receive(event)
