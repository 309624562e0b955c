"""A serial port, which is a terminal here, is for one process at a time."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
import tty
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from voz.errors import RobotError
from voz.robot.serial_port import open_serial_port

HOLD = """
import sys
from voz.robot.serial_port import open_serial_port
port = open_serial_port(sys.argv[1])
print("has it", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def ends() -> Iterator[tuple[int, str]]:
    """The other end of a serial port, and the port's name."""
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    yield ours, os.ttyname(theirs)
    os.close(theirs)
    os.close(ours)


@contextmanager
def held(name: str) -> Iterator[subprocess.Popen[str]]:
    """Another process that has the port."""
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, name],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout
        assert process.stdout.readline() == "has it\n"
        yield process
        process.kill()


def test_a_port_is_read_and_written(ends: tuple[int, str]) -> None:
    ours, name = ends
    with closing(open_serial_port(name)) as port:
        port.write(b"0.10 0.00\n")
        assert os.read(ours, 100) == b"0.10 0.00\n"
        os.write(ours, b"ok\n")
        assert port.read(100) == b"ok\n"
        assert os.get_blocking(port.fileno())


def test_a_port_that_another_process_has_is_refused_by_its_name(ends: tuple[int, str]) -> None:
    _, name = ends
    with held(name) as process:
        user = rf"process {process.pid} \({re.escape(sys.executable)} -c .*{name}\)"
        told = f"^{name} is in use by {user}: end that, or name another port$"
        with pytest.raises(RobotError, match=told):
            open_serial_port(name)
        process.kill()
        process.wait()
        open_serial_port(Path(name)).close()


def test_a_port_that_this_process_has_is_refused_until_it_is_closed(ends: tuple[int, str]) -> None:
    _, name = ends
    with closing(open_serial_port(name)), pytest.raises(RobotError, match=f"process {os.getpid()}"):
        open_serial_port(name)
    open_serial_port(name).close()


def test_what_is_no_port_is_left_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match="ttyUSB0 is not a serial port: plug the adapter in"):
        open_serial_port(tmp_path / "ttyUSB0")
    assert not list(tmp_path.iterdir())


def test_a_port_that_cannot_be_opened_is_told_with_the_reason() -> None:
    program = (
        "from voz.robot.serial_port import open_serial_port\n"
        "try:\n"
        "    open_serial_port('/dev/tty')\n"
        "except Exception as error:\n"
        "    print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        start_new_session=True,  # so that there is no terminal
    )
    assert done.stdout == "/dev/tty cannot be opened (No such device or address)\n"
