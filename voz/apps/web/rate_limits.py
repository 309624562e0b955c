"""Rate limits (token buckets): pure."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable

MAX_CLIENTS = 1000
"""Clients that are counted; for one more, the one that was silent for longest is forgotten."""


class RateLimit:
    """Allows so many per second, and a burst of so many at once."""

    def __init__(self, rate: float, burst: float) -> None:
        self._rate = rate
        self._burst = self._left = burst
        self._last = 0.0

    def allows(self, now: float, amount: float = 1.0) -> bool:
        """Return whether so much more may come at a time, s, and count it if so."""
        self._left = min(self._burst, self._left + (now - self._last) * self._rate)
        self._last = now
        if amount > self._left:
            return False
        self._left -= amount
        return True


class RateLimitPerClient:
    """A `RateLimit` for each client."""

    def __init__(self, rate: float, burst: float) -> None:
        self._rate = rate
        self._burst = burst
        self._limits: OrderedDict[Hashable, RateLimit] = OrderedDict()

    def allows(self, client: Hashable, now: float) -> bool:
        """Return whether one more of a client may come, and count it if so."""
        limit = self._limits.pop(client, None) or RateLimit(self._rate, self._burst)
        self._limits[client] = limit
        if len(self._limits) > MAX_CLIENTS:
            self._limits.popitem(last=False)
        return limit.allows(now)
