"""A festival that hangs, and what has to become of its children."""

from __future__ import annotations

from pathlib import Path

from programs import wait_until


def is_running(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def wait_for_end(slow_festival: Path) -> None:
    """Wait until the child whose id is in a file has ended."""
    child = int(slow_festival.read_text())
    wait_until(lambda: not is_running(child))
