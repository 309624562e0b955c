"""A ROS 2 domain that no other test or program of ours on this computer is in."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

HIGHEST = 100
"""Beyond it the ports of a domain are those that the system gives to others."""


@contextmanager
def free_domain() -> Iterator[int]:
    """Take a domain for a `with` block; a program that is killed gives it back too."""
    folder = Path(tempfile.gettempdir()) / f"voz-domains-{os.getuid()}"
    folder.mkdir(exist_ok=True)
    for number in range(1, HIGHEST + 1):
        with (folder / str(number)).open("w") as taken:
            try:
                fcntl.flock(taken, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            yield number
            return
    raise AssertionError("all domains are taken")
