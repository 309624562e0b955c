"""A robot in its own process: if it hangs, crashes or ends there, the run goes on.

It is the watchdog too. If the beat falls silent, since the run was killed, suspended or hangs, that
process stops the robot (`voz.robot.child`).
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, Pipe
from pathlib import Path

import msgspec

from voz.config import Config
from voz.errors import RobotError, RobotMistake
from voz.events import Event, to_json
from voz.printable import printable_output
from voz.process.forks import close_in_forks
from voz.robot.base import Robot

PROCESS_EXIT_TIMEOUT = 1.0
"""For the process to end when all is over, s; then it is killed."""

MAX_OUTPUT_LINE = 1000
"""Characters of what the robot prints that are shown as one line: it may never end its line."""


class RobotSpec(msgspec.Struct, frozen=True):
    """Which robot a process makes."""

    name: str  # as `voz run --robot` takes it
    settings: Config = Config()
    # Whether it is a watchdog, which only stops the robot if the beat falls silent.
    only_zero: bool = False
    arguments: tuple[str, ...] = ()  # remappings for a ROS 1 node
    path: tuple[str, ...] = ()  # additional folders of Python modules


class EventAnswer(msgspec.Struct, frozen=True):
    """The answer to an event: why the robot failed for good, or is lost for now.

    If it cannot be opened, with the traceback.
    """

    failure: str | None = None
    trouble: str | None = None
    traceback: str | None = None


class RemoteTracebackError(Exception):
    """The traceback of the other process."""


class RobotProcess(Robot):
    """Hands events to a robot in a process of its own, and waits until it has taken each."""

    def __init__(self, spec: RobotSpec, show: Callable[[str], None]) -> None:
        """Prepare to start it; `show` is called with each line that it prints, on any thread."""
        self._spec = spec
        self._show = show
        self._link: Connection
        self._process: subprocess.Popen[str]
        self._answer = EventAnswer()

    def open(self) -> None:
        """Start the process and open the robot there; raises RobotError if that fails."""
        self._link, theirs = Pipe()
        close_in_forks(self._link)
        with theirs:
            self._process = subprocess.Popen(
                command(theirs.fileno()),
                pass_fds=[theirs.fileno()],
                # Its own session keeps Ctrl-C and Ctrl-Z from it: it must stop the robot.
                start_new_session=True,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="backslashreplace",
                env=os.environ | {"PYTHONUNBUFFERED": "1"},
            )
        threading.Thread(target=self._print, name="voz-robot-output", daemon=True).start()
        try:
            self._send(msgspec.json.encode(self._spec))
        except RobotError:
            self.end()
            raise

    def receive(self, event: Event) -> None:
        """Let the robot take an event; raises RobotError if it fails or its process is gone.

        A watchdog that is gone is started again, and is lost until then.
        """
        try:
            self._send(to_json(event).encode())
        except RobotError:
            if not (self._spec.only_zero and self._link.closed):
                raise
            self.open()
            self._answer = EventAnswer(trouble="its process had ended")

    def lost(self) -> str | None:
        """Return why the robot was lost after the last event."""
        return self._answer.trouble

    def close(self) -> None:
        """Let the robot close."""
        with suppress(RobotError):
            self._send(b"")

    def end(self) -> None:
        """End the process, whatever it does; called by its maker."""
        if not hasattr(self, "_process"):
            return
        self._link.close()  # this ends the process
        try:
            self._process.wait(PROCESS_EXIT_TIMEOUT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _send(self, message: bytes) -> None:
        try:
            self._link.send_bytes(message)
            self._answer = msgspec.json.decode(self._link.recv_bytes(), type=EventAnswer)
        except (OSError, EOFError) as error:
            self._link.close()
            raise RobotError("its process has ended") from error
        if self._answer.failure and self._answer.traceback:
            raise RobotMistake(self._answer.failure) from RemoteTracebackError(
                self._answer.traceback
            )
        if self._answer.failure:
            raise RobotError(self._answer.failure)

    def _print(self) -> None:
        assert self._process.stdout
        line_is_new = True
        with self._process.stdout as printed:
            while part := printed.readline(MAX_OUTPUT_LINE):
                if line_is_new or part != "\n":
                    self._show(printable_output(part))
                line_is_new = part.endswith("\n")


def command(descriptor: int) -> Sequence[str]:
    """Return the command line of the process that answers on an open descriptor."""
    here = str(Path(__file__).parents[2])
    start = f"import sys; sys.path.insert(0, {here!r}); from voz.robot.child import main; main()"
    return [sys.executable, "-c", start, str(descriptor)]
