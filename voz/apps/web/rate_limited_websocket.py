"""The WebSocket protocol of the server, with a limit on frames."""

from __future__ import annotations

import time
from typing import Any

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from voz.apps.web.rate_limits import RateLimit

FRAME_RATE, FRAME_BURST = 200.0, 1000.0
"""Frames of one page per second, and at once; its sound is 50 blocks a second."""

READ_SLICE = 4096
"""Bytes that are read before the frames are counted: the smallest frame has 6."""


class RateLimitedWebSocket(WebSocketsSansIOProtocol):
    """Closes the connection of a page that sends too many frames.

    uvicorn answers each ping at once, however many answers wait to be read, and the application,
    which limits messages, sees neither pings nor empty parts of messages.
    """

    def __init__(self, *arguments: Any, **more: Any) -> None:
        super().__init__(*arguments, **more)
        self._limit = RateLimit(FRAME_RATE, FRAME_BURST)

    def data_received(self, data: bytes) -> None:
        """Read what came; a flood is noticed before all of it is read."""
        for start in range(0, len(data), READ_SLICE):
            if not self.transport.is_closing():
                super().data_received(data[start : start + READ_SLICE])

    def handle_events(self) -> None:
        """Handle the frames that were read, or end the connection if there are too many."""
        if self._limit.allows(time.monotonic(), len(self.conn.events)):
            super().handle_events()
        else:
            self.transport.abort()
