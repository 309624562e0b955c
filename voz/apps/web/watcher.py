"""One page that watches: what waits for it is bounded, and the others never wait for it."""

from __future__ import annotations

import asyncio
from collections import deque

MOST_WAITING = 300
"""Records that wait for a page that is slow to take them; with more it is let go."""


class Watcher:
    """What is to be sent to one page; of the states only the newest is.

    Attributes:
        number: of the page, for people.
        secret: lets whoever knows it drive as this page.
        address: where it is.
        stops: how often it has asked for a stop, as it counts them.
        too_slow: whether more waited than may.
    """

    def __init__(self, number: int, secret: str, address: str) -> None:
        self.number = number
        self.secret = secret
        self.address = address
        self.stops = 0
        self.too_slow = False
        self._records: deque[str] = deque()
        self._state: str | None = None
        self._some = asyncio.Event()

    @property
    def name(self) -> str:
        """What people call it."""
        return f"page {self.number} at {self.address}"

    def put(self, record: str) -> None:
        """Send a record after those before it."""
        if len(self._records) >= MOST_WAITING:
            self.too_slow = True
        else:
            self._records.append(record)
        self._some.set()

    def put_state(self, state: str) -> None:
        """Send how all is now, in place of what was not sent yet."""
        self._state = state
        self._some.set()

    async def take(self) -> list[str]:
        """Wait for what is to be sent."""
        await self._some.wait()
        self._some.clear()
        records = [*self._records, *([self._state] if self._state else [])]
        self._records.clear()
        self._state = None
        return records
