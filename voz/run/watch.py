"""Warns that messages came faster than they could be taken."""

from __future__ import annotations

from voz.events import Notice
from voz.inbox import Inbox
from voz.run.dispatcher import Dispatcher

FLOOD_WARNING_INTERVAL = 5.0
"""While messages are dropped, a warning says so once in this time, s."""


class Flood:
    """Warns that messages came faster than they could be taken."""

    def __init__(self, controller: Dispatcher, inbox: Inbox) -> None:
        """Begin with nothing dropped."""
        self._controller = controller
        self._inbox = inbox
        self._seen = self._reported = 0
        self._reported_at = -FLOOD_WARNING_INTERVAL
        self._since = 0.0  # when the first was dropped that was not reported, s

    def check(self, now: float) -> None:
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
