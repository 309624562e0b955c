"""A `voz run` in a process of its own, whose robot notes what it gets."""

from __future__ import annotations

import fcntl
import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from calls import VOZ
from live_robot import signals_as_a_terminal_has_them
from programs import PATIENCE, wait_until

F_SETPIPE_SZ = 1031  # Linux


class Watched:
    """The run, in a folder of its own, and what the robot got."""

    process: subprocess.Popen[bytes]

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def got(self) -> list[str]:
        """What the robot noted: velocities, and that it was closed."""
        return [what for _, what in self.noted()]

    def noted(self) -> list[list[str]]:
        """The same, each with the process that noted it."""
        log = self._folder / "log"
        lines = log.read_text().splitlines(keepends=True) if log.exists() else []
        return [line.split() for line in lines if line.endswith("\n")]

    def wait_for(self, what: str) -> None:
        """Wait until something is the last that the robot noted."""
        wait_until(lambda: self.got()[-1:] == [what])

    def type(self, text: bytes) -> None:
        assert self.process.stdin
        self.process.stdin.write(text)
        self.process.stdin.flush()

    def drive(self) -> None:
        self.type(b"go forward\n")
        self.wait_for("0.1")

    def stands_from_now_on(self) -> None:
        so_far = len(self.got())
        wait_until(lambda: len(self.got()) > so_far + 5)
        assert set(self.got()[so_far:]) == {"0.0"}

    def is_left_with_zero(self) -> None:
        """The robot is closed after a last zero."""
        self.wait_for("closed")
        assert self.got()[-2] == "0.0"

    def end(self) -> None:
        self.process.terminate()
        assert self.process.wait(PATIENCE) == 143
        self.is_left_with_zero()


@contextmanager
def watched(
    folder: Path, environment: dict[str, str], kind: str = "Faulty", sound: bool = False
) -> Iterator[Watched]:
    """Start one; nobody reads what it prints, on the same pipe for both of its outputs."""
    run = Watched(folder)
    ours, theirs = os.pipe()
    fcntl.fcntl(ours, F_SETPIPE_SZ, 4096)  # as few bytes as can be: it is full at once
    with start(folder, environment, theirs, theirs, kind, sound) as run.process:
        os.close(theirs)
        try:
            run.wait_for("0.0")
            yield run
        finally:
            children = folder / "children"
            for process in children.read_text().split() if children.exists() else ():
                os.kill(int(process), signal.SIGKILL)
            run.process.send_signal(signal.SIGCONT)
            run.process.kill()
            os.close(ours)


def start(
    folder: Path,
    environment: dict[str, str],
    stdout: int,
    stderr: int,
    kind: str = "Faulty",
    sound: bool = False,
) -> subprocess.Popen[bytes]:
    """Start it alone, with a robot of `own_robots`."""
    paths = [str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]
    how = ["--listening", "--events", "events.jsonl", *([] if sound else ["--no-sound"])]
    return subprocess.Popen(
        [*VOZ, "run", "--robot", f"own_robots:{kind}", *how],
        cwd=folder,
        env=environment | {"PYTHONPATH": os.pathsep.join(paths)},
        stdin=subprocess.PIPE,
        stdout=stdout,
        stderr=stderr,
        preexec_fn=signals_as_a_terminal_has_them,
    )
