"""Standard input, output and error: always open, and never blocking the program."""

from __future__ import annotations

import io
import os
import queue
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TextIO

from voz.process.signals import is_audio_thread_left

NAMES = ("stdin", "stdout", "stderr")

MAX_QUEUED_TEXTS = 10_000
"""Texts that wait to be written; more are dropped, since nobody would read them any more."""

FLUSH_TIMEOUT = 1.0
"""Time at the end for the queued texts to be written, s; a stopped terminal never takes them."""


def open_streams() -> None:
    """Make the three standard streams usable, whichever of them the caller has closed.

    Else the next opened file would get the number of a closed one, and `print` would write into it.
    """
    for number, name in enumerate(NAMES):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one
            os.set_inheritable(number, True)
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, "w" if number else "r", closefd=False))  # noqa: SIM115
    # File names and typed text may hold bytes that cannot be decoded or shown.
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace" if stream is sys.stdin else "backslashreplace")


def discard_unwritable_output() -> None:
    """Drop buffered output that cannot be written, of which Python would complain at its end."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)


@contextmanager
def quiet_libraries() -> Iterator[None]:
    """Let only Python write to standard error in a `with` block.

    ALSA, PortAudio and libmpg123 write up to ten lines for each error, into the display.
    """
    before = sys.stderr
    if not _has_descriptor(before):
        yield
        return
    theirs = before.fileno()
    before.flush()
    ours = os.fdopen(os.dup(theirs), "w", buffering=1, errors="backslashreplace")
    with open(os.devnull, "w") as nowhere:  # noqa: PTH123
        os.dup2(nowhere.fileno(), theirs)
    sys.stderr = ours
    try:
        yield
    finally:
        ours.flush()
        if not is_audio_thread_left():  # it may still write
            sys.stderr = before
            os.dup2(ours.fileno(), theirs)
            ours.close()


@contextmanager
def unblocked_output() -> Iterator[None]:
    """Let no write to standard output or error wait for its reader in a `with` block.

    A terminal may be stopped by Ctrl-S; what it has not taken at the end is dropped.
    """
    before = {
        name: stream
        for name in ("stdout", "stderr")
        if _has_descriptor(stream := getattr(sys, name))
    }
    ours = [_unblocked(name, stream) for name, stream in before.items()]
    try:
        yield
    finally:
        # Both may be the same pipe: if one is stuck, the other would block, too.
        stuck = [stream for stream in ours if not stream.end()]
        for name, stream in before.items():
            setattr(sys, name, open(os.devnull, "w") if stuck else stream)  # noqa: SIM115, PTH123


class UnblockedStream(io.TextIOBase):
    """A text stream that writes on its own thread, and drops texts when too many are queued."""

    def __init__(self, descriptor: int, encoding: str) -> None:
        self._descriptor = descriptor
        self._encoding = encoding
        self._queue: queue.Queue[bytes | None] = queue.Queue(MAX_QUEUED_TEXTS)
        self._broken: OSError | None = None
        self._thread = threading.Thread(target=self._work, name="voz-output", daemon=True)
        self._thread.start()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """The encoding of the replaced stream."""
        return self._encoding

    def fileno(self) -> int:
        """The descriptor that is written to."""
        return self._descriptor

    def isatty(self) -> bool:
        """Whether the descriptor is a terminal."""
        return os.isatty(self._descriptor)

    def writable(self) -> bool:
        """Always true."""
        return True

    def write(self, text: str) -> int:
        """Queue a text; raises BrokenPipeError if the reader has closed the pipe."""
        if self._broken:
            raise self._broken
        with suppress(queue.Full):
            self._queue.put_nowait(text.encode(self._encoding, "backslashreplace"))
        return len(text)

    def end(self) -> bool:
        """Write the queued texts; returns whether all were written in time."""
        with suppress(queue.Full):
            self._queue.put_nowait(None)
            self._thread.join(FLUSH_TIMEOUT)
        return not self._thread.is_alive()

    def _work(self) -> None:
        try:
            while (data := self._queue.get()) is not None:
                while data:
                    data = data[os.write(self._descriptor, data) :]
        except OSError as error:
            self._broken = error


def _has_descriptor(stream: TextIO | None) -> bool:
    try:
        return stream is not None and stream.fileno() >= 0
    except (AttributeError, OSError, ValueError):
        return False


def _unblocked(name: str, stream: TextIO) -> UnblockedStream:
    stream.flush()
    ours = UnblockedStream(stream.fileno(), stream.encoding)
    setattr(sys, name, ours)
    return ours
