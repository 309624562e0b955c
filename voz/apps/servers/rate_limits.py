"""Rate limits (token buckets): pure."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import lru_cache

REQUEST_RATE, REQUEST_BURST = 100.0, 400.0
"""Requests or events per second, and at once, from one network; fifty pages open with 400.

Stops are not limited.
"""

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


def rate_limit_per_client(rate: float, burst: float) -> Callable[[Hashable], RateLimit]:
    """Return a function from a client to the limit of its own."""
    return lru_cache(MAX_CLIENTS)(lambda _client: RateLimit(rate, burst))
