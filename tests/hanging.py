"""A festival that hangs, and what has to become of its children."""

from __future__ import annotations

from pathlib import Path

from programs import is_alive, wait_until


def wait_for_end(slow_festival: Path) -> None:
    """Wait until the child whose id is in a file has ended."""
    child = int(slow_festival.read_text())
    wait_until(lambda: not is_alive(child))
