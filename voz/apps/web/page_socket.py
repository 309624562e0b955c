"""The WebSocket of a page, which reads no more frames than a page has reason to send."""

from __future__ import annotations

import time
from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from voz.apps.web.limits import Limit

FRAMES_EACH_SECOND, FRAMES_AT_ONCE = 200.0, 1000.0
"""Frames of one page, pings and parts of messages too; its sound is 50 blocks a second."""

SLICE = 4096
"""How much is read before the frames are counted, bytes: the smallest frame has 6."""


class PageSocket(WebSocketsSansIOProtocol):
    """Closes the connection of a page that sends too many frames.

    uvicorn answers each ping at once, however many answers wait to be read, and the application,
    which limits messages, sees neither pings nor empty parts of messages.
    """

    def __init__(self, *arguments: Any, **more: Any) -> None:
        """Make what uvicorn makes, with the same arguments."""
        super().__init__(*arguments, **more)
        self._limit = Limit(FRAMES_EACH_SECOND, FRAMES_AT_ONCE)

    def data_received(self, data: bytes) -> None:
        """Read what came; a flood is noticed before all of it is read."""
        for start in range(0, len(data), SLICE):
            if not self.transport.is_closing():
                super().data_received(data[start : start + SLICE])

    def handle_events(self) -> None:
        """Handle the frames that were read, or end the connection if there are too many."""
        if self._limit.allows(time.monotonic(), len(self.conn.events)):
            super().handle_events()
        else:
            self.transport.abort()
