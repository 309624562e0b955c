"""Hands the events of a run to the server's thread; the beat never waits for it."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator
from contextlib import suppress

from voz.events import Event

MOST_WAITING = 2000
"""Events that wait for a server that is slow; then the oldest go."""


class Feed:
    """A bounded queue from the thread of the beat to the loop of the server."""

    def __init__(self) -> None:
        self._waiting: deque[Event] = deque(maxlen=MOST_WAITING)
        self._loop: asyncio.AbstractEventLoop | None = None
        self._some = asyncio.Event()

    def receive(self, event: Event) -> None:
        """Take an event; called by the beat, it never waits."""
        self._waiting.append(event)
        loop = self._loop
        if loop and not self._some.is_set():
            with suppress(RuntimeError):  # the server has ended
                loop.call_soon_threadsafe(self._some.set)

    async def events(self) -> AsyncIterator[Event]:
        """Give the events as they come; called by the server, without an end."""
        self._loop = asyncio.get_running_loop()
        while True:
            self._some.clear()
            while self._waiting:
                yield self._waiting.popleft()
            await self._some.wait()
