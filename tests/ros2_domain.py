"""A ROS 2 domain that no other test or program of ours on this computer is in."""

from __future__ import annotations

import fcntl
import gc
import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

HIGHEST = 100
"""Beyond it the ports of a domain are those that the system gives to others."""


FORGOTTEN = 15
"""Seconds after which a domain has forgotten a program that was killed; DDS's lease is 10."""


@contextmanager
def free_domain() -> Iterator[int]:
    """Take a domain for a `with` block; a program that is killed gives it back too."""
    folder = Path(tempfile.gettempdir()) / f"voz-domains-{os.getuid()}"
    folder.mkdir(exist_ok=True)
    for path in sorted((folder / str(n) for n in range(1, HIGHEST + 1)), key=_left):
        with path.open("a") as taken:
            try:
                fcntl.flock(taken, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            time.sleep(max(0.0, _left(path) + FORGOTTEN - time.time()))
            taken.write("taken\n")
            taken.flush()
            try:
                yield int(path.name)
            finally:
                gc.collect()  # what this process has in it still
                os.utime(path)
            return
    raise AssertionError("all domains are taken")


def _left(path: Path) -> float:
    """When a domain was left last, as `time.time`; 0 if nobody was in it: its file is empty."""
    return path.stat().st_mtime if path.exists() and path.stat().st_size else 0.0
