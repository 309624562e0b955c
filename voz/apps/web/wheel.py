"""Who drives: one page at a time, the others watch. Pure: the time comes in."""

from __future__ import annotations

NO_SIGN = 0.35
"""A page that has not answered for so long is gone, s: with the beat, half a second (S5)."""

VACANT = 3.0
"""After so long without an answer its place is free for others, s."""

GONE = "the operator's page is gone"


class Wheel:
    """Knows which page drives, and whether it is still there.

    The server's thread changes it, and the beat asks `trouble`.

    Attributes:
        driver: the number of the page that drives; None if none does.
        left_at_rest: whether the beat has just learnt that the driver went, with the robot at rest.
    """

    def __init__(self) -> None:
        self.driver: int | None = None
        self.left_at_rest = False
        self._seen = 0.0  # when the driver last gave a sign, s
        self._closed = False  # the driver has gone, and the beat has not looked yet
        self._lost = False  # the robot moved then, and nobody has come back

    @property
    def just_left(self) -> bool:
        """Whether who drove has gone and the beat has not looked since: the robot may yet move."""
        return self._closed

    def take(self, page: int, over: bool, now: float) -> bool:
        """Let a page drive, if nobody does or it takes over; tells whether it does.

        Args:
            page: its number.
            over: whether it takes over from another that drives.
            now: the time, s.
        """
        if self.driver not in (None, page) and not over:
            return False
        self.driver, self._seen = page, now
        self._closed = self._lost = False
        return True

    def leave(self, page: int) -> bool:
        """Let a page drive no more; tells whether it did."""
        if self.driver != page:
            return False
        self.driver, self._closed = None, True
        return True

    def seen(self, page: int, now: float) -> None:
        """Note a sign of a page, at a time, s."""
        if page == self.driver:
            self._seen, self._lost = now, False

    def vacated(self, now: float) -> bool:
        """Let a driver go that has not given a sign for long; tells whether it was just now."""
        silent = self.driver is not None and now - self._seen > VACANT
        return silent and self.leave(self.driver or 0)

    def trouble(self, now: float, moving: bool) -> str | None:
        """Tell that the page is gone which drove the robot; None while a robot at rest needs none.

        Args:
            now: the time, s.
            moving: whether the robot moves.
        """
        silent = self.driver is not None and now - self._seen > NO_SIGN
        closed = self._closed
        if closed:  # only then is it set: the other thread may set it right now
            self._closed = False
        if moving and (silent or closed):
            self._lost = True
        self.left_at_rest = closed and not moving
        return GONE if self._lost else None
