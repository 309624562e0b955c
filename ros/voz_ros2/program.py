"""The program `ros2 run voz voz`: the command `voz`, which drives ROS 2 if nothing else is said.

ros2 run voz voz --listening        is `voz run --robot ros2 --listening`
ros2 run voz voz doctor             is `voz doctor`
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

WRONG_CALL = 2
"""Exit code, as that of `voz`."""

MISSING = (
    "voz is not installed: call `make ros2` in the clone of voz that this package was built from, "
    "or set VOZ_PYTHON to a Python that has voz"
)
ROS_ARGUMENTS = (
    "voz takes no --ros-args: namespace, topics and domain are settings in [ros2] of voz.toml, "
    "and ROS_DOMAIN_ID"
)


def main() -> None:
    """Become the program; a signal is then for it alone, and stops the robot."""
    given = sys.argv[1:]
    if "--ros-args" in given:
        sys.exit(complain(ROS_ARGUMENTS))
    python = python_with_voz()
    if python is None:
        sys.exit(complain(MISSING))
    os.execv(python, [python, "-m", "voz", *arguments(given)])


def arguments(given: Sequence[str]) -> list[str]:
    """What `voz` is called with: a subcommand is what is there first and no option."""
    if given and not given[0].startswith("-"):
        return list(given)
    return ["run", "--robot", "ros2", *given]


def python_with_voz() -> str | None:
    """Find the Python; None if there is none."""
    return next((python for python in _candidates() if _has_voz(python)), None)


def _candidates() -> Iterator[str]:
    said = os.environ.get("VOZ_PYTHON")
    if said:
        yield said
        return
    here = Path(__file__).resolve()
    place = here.with_name("clone")  # setup.py writes it
    clone = Path(place.read_text().strip()) if place.is_file() else here.parents[2]
    yield str(clone / ".venv" / "bin" / "python")
    yield sys.executable


def _has_voz(python: str) -> bool:
    code = "import importlib.util, sys; sys.exit(importlib.util.find_spec('voz.cli') is None)"
    try:
        # Nothing is looked for in the folder that ROS happens to be in.
        return subprocess.run([python, "-c", code], cwd="/", capture_output=True).returncode == 0
    except OSError:
        return False


def complain(message: str) -> int:
    """Tell what is wrong; gives the exit code."""
    print(f"voz: {message}", file=sys.stderr)
    return WRONG_CALL


if __name__ == "__main__":
    main()
