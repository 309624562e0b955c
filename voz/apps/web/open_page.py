"""One open page: what waits for it is bounded, and the others never wait for it."""

from __future__ import annotations

import asyncio
from collections import deque

MAX_PENDING_RECORDS = 300
"""Records that wait for a slow page; with more its connection is closed."""


class OpenPage:
    """What is to be sent to one page: every record, and of the states only the newest.

    Attributes:
        number: of the page, for people.
        secret: authorizes whoever knows it to drive as this page.
        address: where it is.
        stops: how often it has asked for a stop, by its own count.
        too_slow: whether more records waited than may.
    """

    def __init__(self, number: int, secret: str, address: str) -> None:
        self.number = number
        self.secret = secret
        self.address = address
        self.stops = 0
        self.too_slow = False
        self._records: deque[str] = deque()
        self._state: str | None = None
        self._available = asyncio.Event()

    @property
    def name(self) -> str:
        """What people call it."""
        return f"page {self.number} at {self.address}"

    def put(self, record: str) -> None:
        """Send a record after those before it."""
        if len(self._records) >= MAX_PENDING_RECORDS:
            self.too_slow = True
        else:
            self._records.append(record)
        self._available.set()

    def put_state(self, state: str) -> None:
        """Send a state in place of one that was not sent yet."""
        self._state = state
        self._available.set()

    async def take(self) -> list[str]:
        """Wait for what is to be sent, and return it."""
        await self._available.wait()
        self._available.clear()
        records = [*self._records, *([self._state] if self._state else [])]
        self._records.clear()
        self._state = None
        return records
