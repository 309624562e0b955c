"""A ROS 2 domain of its own for each test, and other programs in it."""

from __future__ import annotations

import json
import platform
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path

import pytest
from calls import VOZ
from programs import Program
from recordings import ROOT
from ros2_domain import free_domain

HERE = Path(__file__).parent
RCLPY = ROOT / ".venv-rclpy" / "bin" / "python"
"""tools/install.sh makes it."""

# The wheels of cyclonedds and the unofficial ones of rclpy are for this processor and some Pythons
# only. Elsewhere what cannot be had is left out, and the first lines of the test run say so.
ORDINARY = platform.machine() == "x86_64" and sys.version_info < (3, 14)
collect_ignore_glob: list[str] = []
if not ORDINARY:
    collect_ignore_glob = [
        "test_base_watchdog.py",
        "test_listener.py",
        "test_on_the_wire.py",
        "test_with_rclpy.py",
    ]
    if find_spec("cyclonedds") is None:
        collect_ignore_glob = ["test_*.py"]


def pytest_report_header() -> list[str]:
    return [f"ROS 2, NOT tested here: {name}" for name in collect_ignore_glob]


@pytest.fixture
def domain(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A domain that no other test uses now; its programs are on this computer alone."""
    with free_domain() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        for name in ("ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS", "CYCLONEDDS_URI"):
            monkeypatch.delenv(name, raising=False)
        yield number


@pytest.fixture
def programs(domain: int) -> Iterator[Callable[..., Program]]:
    """Starts programs: a Python file, and its argument as JSON."""
    with ExitStack() as stack:

        def start(python: Path, file: str, **options: object) -> Program:
            program = Program([str(python), str(HERE / file), json.dumps(options)])
            stack.callback(program.close)
            return program

        yield start


@pytest.fixture
def base(programs: Callable[..., Program]) -> Callable[..., Program]:
    """Starts an rclpy node `/base` that listens to all topics; options are those of rclpy_peer."""
    assert RCLPY.exists(), f"{RCLPY} is missing: run `sh tools/install.sh tests`"

    def start(**options: object) -> Program:
        node = programs(RCLPY, "rclpy_peer.py", **options)
        node.wait_for(lambda line: line.get("ready"))
        return node

    return start


@pytest.fixture
def voz(domain: int, tmp_path: Path) -> Iterator[Callable[..., Program]]:
    """Starts a `voz run` that obeys what is said to it; its events are the lines of JSON.

    It waits so long for a base to be found, s, before it obeys.
    """
    settings = tmp_path / "voz.toml"
    with ExitStack() as stack:

        def start(robot: str, *more: str, wait: float = 30) -> Program:
            settings.write_text(f"[ros2]\nwait = {wait}\n")
            command = f"run --text - --events - --listening --no-sound --robot {robot} --config"
            program = Program([*VOZ, *command.split(), str(settings), *more])
            stack.callback(program.close)
            return program

        yield start


@pytest.fixture
def own(programs: Callable[..., Program]) -> Callable[..., Program]:
    """Starts a program with voz's own Python."""
    return lambda file, **options: programs(Path(sys.executable), file, **options)
