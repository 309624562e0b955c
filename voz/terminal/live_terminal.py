"""A terminal with a live display, and text that is printed above it."""

from __future__ import annotations

import io
import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from rich.console import Console, RenderableType
from rich.file_proxy import FileProxy
from rich.live import Live

REFRESHES_PER_SECOND = 5
"""More is too much for a small computer."""

MAX_WAITING_TEXTS = 100
"""Texts that are printed at a refresh; older ones are dropped and counted."""


class LiveTerminal(io.TextIOBase):
    """A text stream to a terminal with a live display; writing never waits.

    Only the thread that draws prints: two threads would overwrite each other. Control sequences but
    those of colors are removed.
    """

    def __init__(self, console: Console) -> None:
        self.console = console  # the terminal
        self._lines = FileProxy(console, console.file)
        self._waiting: deque[str] = deque(maxlen=MAX_WAITING_TEXTS)
        self._written = 0  # texts since the last print
        self._lock = threading.Lock()

    def writable(self) -> bool:
        """Always true."""
        return True

    def write(self, text: str) -> int:
        """Queue a text, from any thread."""
        with self._lock:
            self._waiting.append(text)
            self._written += 1
        return len(text)

    def print_waiting(self) -> None:
        """Print the queued texts; for the thread that draws, or when nothing is drawn."""
        with self._lock:
            texts, written = list(self._waiting), self._written
            self._waiting.clear()
            self._written = 0
        if texts:
            left_out = written - len(texts)
            self._lines.write((f"... {left_out} more\n" if left_out else "") + "".join(texts))

    @contextmanager
    def live(self, picture: Callable[[], RenderableType]) -> Iterator[None]:
        """Draw what `picture` returns repeatedly in a `with` block."""

        def look() -> RenderableType:
            self.print_waiting()
            return picture()

        drawing = Live(
            console=self.console, get_renderable=look, refresh_per_second=REFRESHES_PER_SECOND
        )
        drawing.start()
        try:
            yield
        finally:
            with suppress(OSError):  # the terminal was closed, which is why it ends
                drawing.stop()
