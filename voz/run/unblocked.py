"""Lets nobody wait for who reads standard output or error: a terminal may be stopped by Ctrl-S."""

from __future__ import annotations

import io
import os
import queue
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TextIO

MOST_WAITING = 10_000
"""Texts that wait; what is written beyond that nobody would read any more."""

CLOSING_TIME = 1.0
"""For what waits to be written at the end, s; who has stopped the terminal does not go on."""


class Unblocked(io.TextIOBase):
    """A text stream that writes on a thread of its own, and drops what waits for too long."""

    def __init__(self, descriptor: int, encoding: str) -> None:
        self._descriptor = descriptor
        self._encoding = encoding
        self._waiting: queue.Queue[bytes | None] = queue.Queue(MOST_WAITING)
        self._broken: OSError | None = None
        self._thread = threading.Thread(target=self._work, name="voz-output", daemon=True)
        self._thread.start()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """As that of the stream in whose place it is."""
        return self._encoding

    def fileno(self) -> int:
        """The descriptor that is written to."""
        return self._descriptor

    def isatty(self) -> bool:
        """Whether that is a terminal."""
        return os.isatty(self._descriptor)

    def writable(self) -> bool:
        """It is."""
        return True

    def write(self, text: str) -> int:
        """Write a text soon; raises BrokenPipeError if nobody reads any more."""
        if self._broken:
            raise self._broken
        with suppress(queue.Full):
            self._waiting.put_nowait(text.encode(self._encoding, "backslashreplace"))
        return len(text)

    def end(self) -> bool:
        """Write what waits, for some time; gives whether all was written."""
        with suppress(queue.Full):
            self._waiting.put_nowait(None)
            self._thread.join(CLOSING_TIME)
        return not self._thread.is_alive()

    def _work(self) -> None:
        try:
            while (data := self._waiting.get()) is not None:
                while data:
                    data = data[os.write(self._descriptor, data) :]
        except OSError as error:
            self._broken = error


@contextmanager
def unblocked_output() -> Iterator[None]:
    """Let nothing wait for standard output and error for the length of a `with` block.

    If somebody does not take at its end what was written, nothing more is shown.
    """
    before = {
        name: stream for name in ("stdout", "stderr") if _is_file(stream := getattr(sys, name))
    }
    ours = [_take_the_place_of(name, stream) for name, stream in before.items()]
    try:
        yield
    finally:
        # Both may be the same pipe, so that one which is stuck would hold up the other, too.
        stuck = [stream for stream in ours if not stream.end()]
        for name, stream in before.items():
            # What is shown now must not wait; a file that nobody closes has no end to wait for.
            setattr(sys, name, open(os.devnull, "w") if stuck else stream)  # noqa: SIM115, PTH123


def _is_file(stream: TextIO | None) -> bool:
    try:
        return stream is not None and stream.fileno() >= 0
    except (AttributeError, OSError, ValueError):
        return False


def _take_the_place_of(name: str, stream: TextIO) -> Unblocked:
    stream.flush()
    ours = Unblocked(stream.fileno(), stream.encoding)
    setattr(sys, name, ours)
    return ours
