"""The program that is hunted, started for real, and its terminal or pipes."""

from __future__ import annotations

import fcntl
import os
import pty
import resource
import select
import signal
import struct
import subprocess
import termios
import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from pathlib import Path

from live_robot import signals_as_a_terminal_has_them

F_SETPIPE_SZ = 1031  # Linux
PIPE = 4096
"""Bytes that wait in a pipe, as few as can be: an unread one blocks at once."""

FILE_LIMIT = 20_000
"""Bytes that a file may have where the disk is to be full soon."""


class Quarry:
    """A program that drives a robot, and its terminal or pipes.

    Attributes:
        has: the features that actions ask for.
        setup: how it is started, in words.
        command_line: what starts it.
        environment: its own.
        folder: for all its files.
        process: the program; it leads a session of its own.
        spawned: when it was started, on the monotonic clock, s.
        reading: whether what it writes is read.
        said: what it wrote last.
    """

    process: subprocess.Popen[bytes]

    def __init__(self, folder: Path, environment: dict[str, str], terminal: bool, one: bool):
        """Open a terminal or pipes, stdout and stderr in `one` or each in its own."""
        self.folder, self.environment = folder, environment
        self.has = {"terminal" if terminal else "pipes"}
        self.setup = ["in a terminal" if terminal else f"in {'one pipe' if one else 'pipes'}"]
        self.command_line: list[str] = []
        self.full_disk = False
        self.reading = threading.Event()
        self.reading.set()
        self.said = b""
        self._theirs, self._to, self._sources = _terminal() if terminal else _pipes(one)
        self._ours = {self._to, *self._sources}
        os.set_blocking(self._to, False)
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def start(self) -> None:
        """Start it; what was typed before waits on its standard input."""
        self.spawned = time.monotonic()
        stdin, stdout, stderr = self._theirs
        self.process = subprocess.Popen(
            self.command_line,
            env=self.environment,
            cwd=self.folder,
            start_new_session=True,
            preexec_fn=self._in_the_child,
            stdin=stdin,
            stdout=stdout,
            stderr=stderr,
        )
        for stream in set(self._theirs):
            os.close(stream)

    def feed(self, data: bytes) -> None:
        """Let keys or lines arrive on its standard input; none are lost if it reads at all."""
        deadline = time.monotonic() + 5
        with suppress(BrokenPipeError):  # it has ended
            while data and time.monotonic() < deadline:
                with suppress(BlockingIOError):
                    data = data[os.write(self._to, data[:PIPE]) :]
                if data:
                    time.sleep(0.002)

    def command(self, text: str) -> None:
        """Type a command; another kind of program may be told in another way."""
        self.feed(f"{text}\n".encode())

    def demand(self, what: str, how: str) -> Path:
        """Demand a fault of what was built into it; gives the file that does so."""
        file = self.wish(what)
        aside = file.with_name("aside")
        aside.write_text(how)
        return aside.rename(file)

    def wish(self, what: str) -> Path:
        return self.folder / f"do {what}"

    def close_terminal(self) -> None:
        self._sources.clear()
        time.sleep(0.15)  # nobody reads from it any more
        os.close(self._to)
        self._ours.remove(self._to)
        self._to = os.open(os.devnull, os.O_WRONLY)
        self._ours.add(self._to)

    def processes(self) -> list[int]:
        """Its own, and those that it started, wherever they went."""
        found = []
        for process in Path("/proc").glob("[0-9]*"):
            with suppress(OSError):
                if (process / "cwd").readlink() == self.folder:
                    found.append(int(process.name))
        return found

    def signal_all(self, number: int) -> None:
        for process in self.processes():
            with suppress(ProcessLookupError):
                os.kill(process, number)

    def stacks(self) -> list[str]:
        """Where its threads are now, if it can tell, and what it said last."""
        file = self.folder / "stacks"
        if file.exists() and self.process.poll() is None:
            self.process.send_signal(signal.SIGUSR1)
            time.sleep(0.3)
        lines = file.read_text().splitlines() if file.exists() else []
        said = self.said.decode(errors="replace")[-1500:].splitlines()
        return [*(line for line in lines if "/voz/" in line or line.startswith("Thread")), *said]

    def end(self) -> None:
        """End it in any case, with all its children."""
        self.signal_all(signal.SIGKILL)
        self.process.wait()
        self.reading.set()
        self._reader.join(2)
        for each in self._ours:
            os.close(each)

    def _read(self) -> None:
        while self._sources:
            if not self.reading.wait(0.1):
                continue
            for source in select.select(list(self._sources), [], [], 0.1)[0]:
                try:
                    data = os.read(source, 65536)
                except OSError:  # the terminal is gone
                    data = b""
                self.said = (self.said + data)[-20_000:]
                if not data:
                    self._sources.remove(source)

    def _in_the_child(self) -> None:
        signals_as_a_terminal_has_them()
        if self.full_disk:
            resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_LIMIT, FILE_LIMIT))
        if os.isatty(0):
            os.close(os.open(os.ttyname(0), os.O_RDWR))  # now it is the session's own


def _terminal() -> tuple[Sequence[int], int, list[int]]:
    """Open a terminal: the program's three streams, what to write to, what to read from."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("4H", 30, 100, 0, 0))
    return (theirs, theirs, theirs), ours, [ours]


def _pipes(one: bool) -> tuple[Sequence[int], int, list[int]]:
    stdin, to = os.pipe()
    out, stdout = os.pipe()
    err, stderr = (out, stdout) if one else os.pipe()
    sources = list({out, err})
    for source in sources:
        fcntl.fcntl(source, F_SETPIPE_SZ, PIPE)
    return (stdin, stdout, stderr), to, sources


def started(
    command: Sequence[str], environment: dict[str, str], parts: ExitStack
) -> subprocess.Popen[bytes]:
    """Start another program, that ends with `parts`."""
    process = subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    parts.callback(_ended, process)
    return process


def _ended(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()
    for stream in (process.stdin, process.stdout):
        assert stream
        with suppress(BrokenPipeError):
            stream.close()
