"""Which page is driving: one at a time, the others watch. Pure: time comes in as an argument."""

from __future__ import annotations

DRIVER_TIMEOUT = 0.35
"""A page that has not answered for so long is gone, s: with the beat, half a second (S5)."""

RELEASE_TIMEOUT = 3.0
"""After so long without an answer another page may drive, s."""

PAGE_GONE = "the operator's page is gone"


class DriverLock:
    """Held by the page that is driving.

    The server's thread changes it; the control loop calls `trouble`.

    Attributes:
        driver: the number of the page that is driving; None if none is.
        released_at_rest: whether the last `trouble` found that the driver has left a robot at rest.
        reported_gone: whether the last `trouble` found that the driver of a moving robot is gone.
    """

    def __init__(self) -> None:
        self.driver: int | None = None
        self.released_at_rest = False
        self.reported_gone = False
        self._last_answer = 0.0  # of the driver, s
        self._released = False  # the driver has gone, and `trouble` was not called since
        self._lost = False  # the robot moved then, and nobody has come back

    def is_answering(self, page: int, now: float) -> bool:
        """Whether a page drives and does not count as gone."""
        return page == self.driver and not self._is_silent(now)

    @property
    def just_released(self) -> bool:
        """Whether the driver has gone since the last `trouble`: the robot may still move."""
        return self._released

    def acquire(self, page: int, take_over: bool, now: float) -> bool:
        """Let a page drive if nobody does, or if it takes over; returns whether it drives."""
        if self.driver not in (None, page) and not take_over:
            return False
        self.driver, self._last_answer = page, now
        self._released = self._lost = False
        return True

    def release(self, page: int) -> bool:
        """Let a page drive no more; returns whether it did."""
        if self.driver != page:
            return False
        self.driver, self._released = None, True
        return True

    def keep_alive(self, page: int, now: float) -> None:
        """Note an answer of a page."""
        if page == self.driver:
            self._last_answer, self._lost = now, False

    def release_if_silent(self, now: float) -> bool:
        """Release a driver that has not answered for long; returns whether it was just now."""
        if self.driver is None or now - self._last_answer <= RELEASE_TIMEOUT:
            return False
        return self.release(self.driver)

    def trouble(self, now: float, moving: bool) -> str | None:
        """Report that the page that drove a moving robot is gone; None for a robot at rest."""
        silent = self.driver is not None and self._is_silent(now)
        released = self._released
        if released:  # only then: the other thread may set it right now
            self._released = False
        if moving and (silent or released):
            self._lost = True
        self.released_at_rest = released and not moving
        self.reported_gone = self._lost
        return PAGE_GONE if self.reported_gone else None

    def _is_silent(self, now: float) -> bool:
        return now - self._last_answer > DRIVER_TIMEOUT
