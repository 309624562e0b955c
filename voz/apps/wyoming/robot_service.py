"""Takes commands for the robot of a run by the Wyoming protocol, on a thread of its own."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, nullcontext, suppress
from functools import partial

from voz.apps.servers.rate_limits import (
    REQUEST_BURST,
    REQUEST_RATE,
    RateLimit,
    rate_limit_per_client,
)
from voz.apps.wyoming.announcement import announced
from voz.apps.wyoming.command_handler import (
    COMMAND_BURST,
    COMMAND_RATE,
    CommandHandler,
    RobotAccess,
)
from voz.apps.wyoming.connection import serving
from voz.apps.wyoming.given_commands import WYOMING_SOURCE, GivenCommands
from voz.errors import ConfigError
from voz.events import Event
from voz.inbox import Inbox
from voz.language.sentences.command_set import Commands
from voz.run.clocks import Clock, warner

SERVER_SHUTDOWN_TIMEOUT = 2.0
"""For the server to end, s; the robot is at rest by then."""


class RobotService:
    """Lets Wyoming clients drive the robot of a run.

    Attributes:
        source: of the commands; who gives them does not watch the robot.
    """

    source = WYOMING_SOURCE

    def __init__(
        self,
        uri: str,
        commands: Callable[[], Commands],
        language: str,
        inbox: Inbox,
        clock: Clock,
        page_drives: Callable[[], bool],
        announce: bool = True,
    ) -> None:
        """Prepare to serve.

        Args:
            uri: where it is asked, `tcp://HOST:PORT` or `unix://FILE`.
            commands: returns what may be said now.
            language: its code.
            inbox: where commands go.
            clock: the time of the run.
            page_drives: returns whether somebody drives from the operator page; then only commands
                that stop the robot are obeyed.
            announce: whether to announce it in the network.
        """
        self._uri = uri
        self._given = GivenCommands(inbox, clock.now, commands)
        self._robot = RobotAccess(
            self._given, inbox, commands, language, page_drives,
            limit=RateLimit(COMMAND_RATE, COMMAND_BURST),
            event_limit_of=rate_limit_per_client(REQUEST_RATE, REQUEST_BURST),
        )  # fmt: skip
        self._announce = announce
        self._warn = warner(inbox, clock)

    def receive(self, event: Event) -> None:
        """Take an event of the run; it never waits."""
        self._given.receive(event)

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
            async with announced(self._uri, self._warn) if self._announce else nullcontext():
                await ended.wait()
