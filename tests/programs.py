"""Other programs that a test starts, talks with and ends."""

from __future__ import annotations

import json
import random
import socket
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any

import pytest

PATIENCE = 60.0
"""A busy machine may need that long, s; a good one does not."""


class Program:
    """Another program, whose lines of JSON can be waited for."""

    def __init__(self, command: list[str]) -> None:
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        )
        self._lines: SimpleQueue[dict[str, Any]] = SimpleQueue()
        self._reader = Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout
        for line in self.process.stdout:
            self._lines.put(json.loads(line))

    @property
    def is_silent(self) -> bool:
        """Whether it has printed nothing that was not waited for yet."""
        return self._lines.empty()

    def say(self, line: str) -> None:
        assert self.process.stdin
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()

    def wait_for(self, wanted: Callable[[dict[str, Any]], object]) -> list[dict[str, Any]]:
        """All lines up to the first that is wanted, which is the last of them."""
        heard: list[dict[str, Any]] = []
        until = time.monotonic() + PATIENCE
        while not heard or not wanted(heard[-1]):
            try:
                heard.append(self._lines.get(timeout=max(0.0, until - time.monotonic())))
            except Empty:
                pytest.fail(f"waited {PATIENCE:g} s, and all that came was {heard[-20:]}")
        return heard

    def end(self, number: int) -> None:
        """Send a signal, and wait until the program has gone."""
        self.process.send_signal(number)
        self.process.wait(PATIENCE)

    def close(self) -> None:
        """End it in any case, and let go of it."""
        with self.process:  # closes the pipes
            self.process.kill()
            self._reader.join()


def free_port() -> int:
    """A port of this computer that nobody uses.

    It is below those of which the system gives one to whoever asks for any: such a one could be
    somebody else's before a server takes it.
    """
    while True:
        with socket.socket() as free, suppress(OSError):
            free.bind(("127.0.0.1", random.randrange(20_000, 32_768)))
            port: int = free.getsockname()[1]
            return port


def wait_until(true: Callable[[], object]) -> None:
    until = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < until, "waited in vain"
        time.sleep(0.02)


def is_alive(process: int) -> bool:
    """Whether a process runs; one that has ended may still wait to be asked how."""
    try:
        return "\nState:\tZ" not in Path(f"/proc/{process}/status").read_text()
    except OSError:
        return False
