"""Opens serial ports, each for one process at a time."""

from __future__ import annotations

import fcntl
import os
import time
from io import FileIO
from pathlib import Path

from voz.errors import RobotError

PORT_RELEASE_TIMEOUT = 1.0
"""For another process to let go of the port, s: that of a robot whose run was killed stops the
robot for half a second and ends."""

MAX_COMMAND_LINE = 200
"""Characters that are shown of another process's command line."""


def open_serial_port(name: str | Path) -> FileIO:
    """Open a serial port, such as /dev/ttyUSB0, for this process alone.

    It is locked as pyserial does with `exclusive=True`; its speed is as `stty` has set it.

    Raises:
        RobotError: it is no serial port, another process has it, or it cannot be opened.
    """
    path = Path(name)
    if not path.is_char_device():  # opening it would create a file of that name
        raise RobotError(f"{path} is not a serial port: plug the adapter in, or name another")
    try:
        # The port must not become the terminal of this process, nor opening wait for a carrier.
        port = FileIO(os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK), "r+")
        os.set_blocking(port.fileno(), True)
    except OSError as error:
        raise RobotError(f"{path} cannot be opened ({error.strerror})") from error
    until = time.monotonic() + PORT_RELEASE_TIMEOUT
    while not _locked(port):
        if time.monotonic() > until:
            port.close()
            user = _who_has_locked(path)
            raise RobotError(f"{path} is in use by {user}: end that, or name another port")
        time.sleep(0.02)
    return port


def _locked(port: FileIO) -> bool:
    try:
        fcntl.flock(port, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _who_has_locked(path: Path) -> str:
    """Name the process that has locked a file, as far as /proc shows it."""
    file = path.stat()
    number = f"{os.major(file.st_dev):02x}:{os.minor(file.st_dev):02x}:{file.st_ino}"
    try:
        locks = [line.split() for line in Path("/proc/locks").read_text().splitlines()]
        pid = next(lock[4] for lock in locks if lock[1] == "FLOCK" and lock[5] == number)
        return f"process {pid} ({_command_line(pid)})"
    except (OSError, StopIteration):  # in another container, or just ended
        return "another process"


def _command_line(pid: str) -> str:
    """Return the command line of a process; of a robot's process, that of its run."""
    process = Path("/proc") / pid
    command = process.joinpath("cmdline").read_text(errors="replace").replace("\0", " ").strip()
    if "voz.robot.child" in command:
        parent = process.joinpath("stat").read_text().rpartition(")")[2].split()[1]
        return _command_line(parent)
    return command[:MAX_COMMAND_LINE]
