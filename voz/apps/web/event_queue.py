"""Passes the events of a run to the server's thread; the control loop never waits for it."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator
from contextlib import suppress

from voz.events import Event

MAX_QUEUED_EVENTS = 2000
"""Events that wait for a slow server; then the oldest are dropped."""


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
