"""S5: when hearing or a robot is lost, the motion ends, and needs a new command to begin again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from voz.drive import Drive
from voz.events import Warning


class Watch:
    """Looks after one thing that a run needs.

    Attributes:
        lost: whether it was lost when last looked at.
    """

    def __init__(self, drive: Drive, trouble: Callable[[], str | None], again: str) -> None:
        """Begin with all well.

        Args:
            drive: what stops.
            trouble: tells why the thing is lost now; None if it is not.
            again: says that it is back.
        """
        self._drive = drive
        self._trouble = trouble
        self._again = again
        self.lost = False

    def look(self, now: float) -> None:
        """Stop if it was lost just now, and tell; the same if it is back.

        Args:
            now: the time of the run, s.
        """
        found = self._trouble()
        if bool(found) == self.lost:
            return
        self.lost = bool(found)
        self._drive.halt()  # also when it is back: what was said meanwhile is out of date
        again = f"{self._again}; the robot waits for a command"
        self._drive.emit(Warning(now, f"{found}: the robot stops" if found else again))


def over_robots(drive: Drive, lost: Mapping[str, Callable[[], str | None]]) -> Sequence[Watch]:
    """Look after robots.

    Args:
        drive: what stops.
        lost: tells of each, by its name, why it is lost.
    """
    return [Watch(drive, trouble, f"{name} is there") for name, trouble in lost.items()]
