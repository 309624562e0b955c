"""voz in a terminal of its own, and what is to be seen there."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import time
from collections.abc import Callable
from pathlib import Path

from calls import VOZ
from programs import PATIENCE

ROWS, COLUMNS = 30, 100

CONTROL = re.compile(r"\x1b\[([?0-9;]*)([A-Za-z])|(\r)|(\n)")


def rows(shown: str) -> list[str]:
    """What stands on a terminal, with all that has left it at the top, without colors."""
    lines, row, column = [""], 0, 0
    place = 0
    for control in CONTROL.finditer(shown):
        text = shown[place : control.start()]
        lines[row] = lines[row][:column].ljust(column) + text + lines[row][column + len(text) :]
        column += len(text)
        place = control.end()
        number, kind, back, down = control.groups()
        if back:
            column = 0
        elif down:
            row, column = row + 1, 0
            lines += [""] * (row == len(lines))
        elif kind == "A":
            row -= int(number or 1)
        elif kind == "K":
            lines[row] = ""
    return lines


COLOR = re.compile(r"\x1b\[[0-9;]*m")

RUN = ("run", "--listening", "--no-sound")


class Terminal:
    """A `voz run`, or another command, in a terminal of its own."""

    def __init__(
        self,
        environment: dict[str, str],
        folder: Path,
        *arguments: str,
        command: tuple[str, ...] = RUN,
    ) -> None:
        self._log = folder / "events.jsonl"
        self._ours, theirs = pty.openpty()
        self._open = [self._ours, theirs]
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", ROWS, COLUMNS, 0, 0))
        self.before = termios.tcgetattr(theirs)
        self._theirs = theirs
        self.shown = b""
        events = ("--events", str(self._log)) if command[0] == "run" else ()
        self.process = subprocess.Popen(
            [*VOZ, *command, *events, *arguments],
            cwd=folder,
            env=environment | {"TERM": "xterm"},
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            start_new_session=True,
            preexec_fn=take_the_terminal,
        )

    def settings(self) -> list[object]:
        return termios.tcgetattr(self._theirs)

    def type(self, keys: str) -> None:
        os.write(self._ours, keys.encode())

    def look(self) -> str:
        """What the program has shown so far."""
        while select.select([self._ours], [], [], 0.05)[0]:
            self.shown += os.read(self._ours, 65536)
        return self.shown.decode(errors="replace")

    def rows(self) -> list[str]:
        """What stands on it, and what stood there before."""
        return rows(self.look())

    def events(self) -> list[dict[str, object]]:
        text = self._log.read_text() if self._log.exists() else ""
        return [json.loads(line) for line in text.splitlines(keepends=True) if line[-1] == "\n"]

    def wait_for_velocity(self, linear: float) -> None:
        deadline = time.monotonic() + 60
        while not self.events() or self.events()[-1].get("linear") != linear:
            assert self.process.poll() is None, self.look()
            assert time.monotonic() < deadline, self.look()
            self.look()

    def wait_for(self, sought: Callable[[dict[str, object]], bool]) -> dict[str, object]:
        """Wait for an event."""
        deadline = time.monotonic() + 60
        while not (found := [event for event in self.events() if sought(event)]):
            assert self.process.poll() is None, self.look()
            assert time.monotonic() < deadline, self.look()
            self.look()
        return found[0]

    def wait_to_see(self, text: str) -> None:
        deadline = time.monotonic() + PATIENCE
        while text not in COLOR.sub("", self.look()):
            assert time.monotonic() < deadline, self.look()

    def end(self) -> int:
        """Wait until the program has ended; what it still shows is taken from it."""
        deadline = time.monotonic() + PATIENCE
        while self.process.poll() is None:
            assert time.monotonic() < deadline
            self.look()
        self.look()
        return self.process.returncode

    def hang_up(self) -> None:
        """Close the terminal, as its window does."""
        while self._open:
            os.close(self._open.pop())

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        self.hang_up()


def take_the_terminal() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    os.close(os.open(os.ttyname(0), os.O_RDWR))  # now it is the session's own
