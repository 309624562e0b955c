"""How often somebody may ask for something: pure."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable

MOST_KNOWN = 1000
"""Whose requests are counted; whoever has not asked for longest is forgotten for another one."""


class Limit:
    """Lets so many through in a second, and some at once."""

    def __init__(self, each_second: float, at_once: float) -> None:
        """Begin with nothing used.

        Args:
            each_second: how many in the long run.
            at_once: how many before that.
        """
        self._each_second = each_second
        self._most = self._left = at_once
        self._last = 0.0

    def allows(self, now: float, amount: float = 1.0) -> bool:
        """Tell whether more may come, and count it if so.

        Args:
            now: the time, s; it never goes back.
            amount: how much more.
        """
        self._left = min(self._most, self._left + (now - self._last) * self._each_second)
        self._last = now
        if amount > self._left:
            return False
        self._left -= amount
        return True


class LimitOfEach:
    """Lets so many of each one through."""

    def __init__(self, each_second: float, at_once: float) -> None:
        """Begin with nothing used; the arguments are those of `Limit`."""
        self._each_second = each_second
        self._at_once = at_once
        self._limits: OrderedDict[Hashable, Limit] = OrderedDict()

    def allows(self, one: Hashable, now: float) -> bool:
        """Tell whether one more of them may come, and count it if so.

        Args:
            one: who asks.
            now: the time, s; it never goes back.
        """
        limit = self._limits.pop(one, None) or Limit(self._each_second, self._at_once)
        self._limits[one] = limit
        if len(self._limits) > MOST_KNOWN:
            self._limits.popitem(last=False)
        return limit.allows(now)
