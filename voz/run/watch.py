"""S5: when hearing or a robot is lost, the robot stops and waits for a new command."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from voz.events import Event, Notice, Utterance
from voz.inbox import Inbox
from voz.run.controller import Controller

FLOOD_WARNING_INTERVAL = 5.0
"""While messages are dropped, a warning says so once in this time, s."""

Trouble: TypeAlias = Callable[[], str | None]
"""Returns why something is lost now, without waiting; None if it is not."""


class Watch:
    """Stops the robot when one thing that a run needs is lost, and when it is back."""

    def __init__(
        self,
        controller: Controller,
        trouble: Trouble,
        again: str,
        *sources: str,
        mark_late: Callable[[str, bool], None] | None = None,
    ) -> None:
        """Begin with all well.

        Args:
            controller: what stops.
            trouble: returns why the thing is lost.
            again: the message that it is back.
            sources: of the commands that come from it; while it is lost they move nothing.
            mark_late: notes whether a source is behind; None is the controller's own.
        """
        self._controller = controller
        self._trouble = trouble
        self._again = again
        self._sources = sources
        self._mark_late = mark_late or controller.mark_late
        self.in_trouble = False
        self._commanded = False  # since the loss, by somebody who is still there
        controller.receivers.append(self._receive)

    def look(self, now: float) -> None:
        """Stop, and say why, if it was lost or came back just now; `now` in s.

        While it is lost, what moves the robot is stopped again, unless it is a new command that
        came from elsewhere.
        """
        found = self._trouble()
        if bool(found) != self.in_trouble:
            self.in_trouble, self._commanded = bool(found), False
            for source in self._sources:
                self._mark_late(source, self.in_trouble)
        elif not found or self._commanded or not self._controller.moving:
            return
        again = f"{self._again}; the robot waits for a command"
        # Also when it is back: commands of the meantime are out of date.
        self._controller.stop(now, f"{found}: the robot stops" if found else again, good=not found)

    def _receive(self, event: Event) -> None:
        if isinstance(event, Utterance) and event.obeyed:
            self._commanded = event.source not in self._sources


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
