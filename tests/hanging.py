"""A festival that hangs, and what has to become of its children."""

from __future__ import annotations

import time
from pathlib import Path


def is_running(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def wait_for_end(slow_festival: Path) -> None:
    """Wait until the child whose id is in a file has ended."""
    child = int(slow_festival.read_text())
    deadline = time.monotonic() + 5
    while is_running(child):
        assert time.monotonic() < deadline
        time.sleep(0.01)
