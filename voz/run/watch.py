"""S5: when hearing or a robot is lost, the motion ends, and needs a new command to begin again."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from voz.events import Warning
from voz.inbox import Inbox
from voz.run.controller import Controller

FLOOD_TOLD_EVERY = 5.0
"""Of messages that are dropped again and again a user wants to read a line now and then, s."""


class Watch:
    """Looks after one thing that a run needs.

    Attributes:
        in_trouble: whether it was lost when last looked at.
    """

    def __init__(
        self,
        controller: Controller,
        trouble: Callable[[], str | None],
        again: str,
        source: str | None = None,
    ) -> None:
        """Begin with all well.

        Args:
            controller: what stops.
            trouble: tells why the thing is lost now; None if it is not. It may not wait.
            again: says that it is back.
            source: of the utterances that come from it, if it hears.
        """
        self._controller = controller
        self._trouble = trouble
        self._again = again
        self._source = source
        self.in_trouble = False

    def look(self, now: float) -> None:
        """Stop if it was lost just now, and tell; the same if it is back.

        Args:
            now: the time of the run, s.
        """
        found = self._trouble()
        if bool(found) == self.in_trouble:
            return
        self.in_trouble = bool(found)
        if self._source:
            self._controller.late_from(self._source, self.in_trouble)
        again = f"{self._again}; the robot waits for a command"
        # Also when it is back: what was said meanwhile is out of date.
        self._controller.stop(now, f"{found}: the robot stops" if found else again, good=not found)


class Flood:
    """Warns that messages came faster than they could be taken."""

    def __init__(self, controller: Controller, inbox: Inbox) -> None:
        """Begin with nothing dropped."""
        self._controller = controller
        self._inbox = inbox
        self._seen = self._told = 0
        self._told_at = -FLOOD_TOLD_EVERY
        self._since = 0.0  # when the first was dropped that was not told, s

    def look(self, now: float) -> None:
        """Warn if messages were dropped: when no more are, or now and then; `now` in s."""
        dropped = self._inbox.dropped
        ended, self._seen = dropped == self._seen, dropped
        if dropped == self._told:
            self._since = now
        elif now - self._told_at >= FLOOD_TOLD_EVERY and (
            ended or now - self._since >= FLOOD_TOLD_EVERY
        ):
            text = f"{dropped - self._told} messages came too fast and were dropped"
            self._told, self._told_at = dropped, now
            self._controller.emit(Warning(now, text))


def over_robots(
    controller: Controller, troubles: Mapping[str, Callable[[], str | None]]
) -> list[Watch]:
    """Look after robots.

    Args:
        controller: what stops.
        troubles: tells of each, by its name, why it is lost.
    """
    return [Watch(controller, trouble, f"{name} is there") for name, trouble in troubles.items()]
