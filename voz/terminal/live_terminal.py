"""A terminal on which something is drawn all the time, and lines that are printed above it."""

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
"""Times a second that it is drawn anew; more costs a small computer too much."""

MAX_WAITING_TEXTS = 100
"""Texts that are printed at once: more do not fit on a terminal, and nobody reads that fast."""


class LiveTerminal(io.TextIOBase):
    """A text stream to a terminal; writing never waits.

    What is written is printed by the thread that draws: of two threads each would take what the
    other has drawn for its own. Control sequences but those of colors are left out.

    Attributes:
        console: the terminal.
    """

    def __init__(self, console: Console) -> None:
        """Prepare to draw on a terminal."""
        self.console = console
        self._lines = FileProxy(console, console.file)
        self._waiting: deque[str] = deque(maxlen=MAX_WAITING_TEXTS)
        self._written = 0  # texts since the last print
        self._lock = threading.Lock()

    def writable(self) -> bool:
        """It is."""
        return True

    def write(self, text: str) -> int:
        """Print whole lines soon; of too many the oldest are left out and counted. Any thread."""
        with self._lock:
            self._waiting.append(text)
            self._written += 1
        return len(text)

    def print_waiting(self) -> None:
        """Print what was written; for the thread that draws, or when nothing is drawn."""
        with self._lock:
            texts, written = list(self._waiting), self._written
            self._waiting.clear()
            self._written = 0
        if texts:
            left_out = written - len(texts)
            self._lines.write((f"... {left_out} more\n" if left_out else "") + "".join(texts))

    @contextmanager
    def live(self, picture: Callable[[], RenderableType]) -> Iterator[None]:
        """Draw something anew, again and again, for the length of a `with` block.

        Args:
            picture: returns how it looks now.
        """

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
