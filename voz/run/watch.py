"""S5: when hearing or a robot is lost, the robot stops and waits for a new command."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from voz.events import Notice
from voz.inbox import Inbox
from voz.run.controller import Controller

FLOOD_WARNING_INTERVAL = 5.0
"""While messages are dropped, a warning says so once in this time, s."""

Trouble: TypeAlias = Callable[[], str | None]
"""Returns why something is lost now, without waiting; None if it is not."""


class Watch:
    """Stops the robot when one thing that a run needs is lost, and when it is back."""

    def __init__(
        self, controller: Controller, trouble: Trouble, again: str, source: str | None = None
    ) -> None:
        """Begin with all well.

        Args:
            controller: what stops.
            trouble: returns why the thing is lost.
            again: the message that it is back.
            source: of the utterances that come from it, if it hears.
        """
        self._controller = controller
        self._trouble = trouble
        self._again = again
        self._source = source
        self.in_trouble = False

    def look(self, now: float) -> None:
        """Stop, and say why, if it was lost or came back just now; `now` in s."""
        found = self._trouble()
        if bool(found) == self.in_trouble:
            return
        self.in_trouble = bool(found)
        if self._source:
            self._controller.mark_late(self._source, self.in_trouble)
        again = f"{self._again}; the robot waits for a command"
        # Also when it is back: commands of the meantime are out of date.
        self._controller.stop(now, f"{found}: the robot stops" if found else again, good=not found)


class Flood:
    """Warns that messages came faster than they could be taken."""

    def __init__(self, controller: Controller, inbox: Inbox) -> None:
        """Begin with nothing dropped."""
        self._controller = controller
        self._inbox = inbox
        self._seen = self._reported = 0
        self._reported_at = -FLOOD_WARNING_INTERVAL
        self._since = 0.0  # when the first was dropped that was not reported, s

    def look(self, now: float) -> None:
        """Warn if messages were dropped, at the end of a flood or every 5 s; `now` in s."""
        dropped = self._inbox.dropped
        ended, self._seen = dropped == self._seen, dropped
        if dropped == self._reported:
            self._since = now
        elif now - self._reported_at >= FLOOD_WARNING_INTERVAL and (
            ended or now - self._since >= FLOOD_WARNING_INTERVAL
        ):
            text = f"{dropped - self._reported} messages came too fast and were dropped"
            self._reported, self._reported_at = dropped, now
            self._controller.emit(Notice(now, text))
