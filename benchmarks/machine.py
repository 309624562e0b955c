"""What every benchmark prints or needs: its machine, its peak memory, and what is wrong."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from voz.apps.evaluation.report import machine as machine
from voz.errors import VozError


@contextmanager
def one_line_errors() -> Iterator[None]:
    """End the program with one line and exit code 2 if a file is no good in a `with` block."""
    try:
        yield
    except (VozError, OSError) as error:
        print(error, file=sys.stderr)
        sys.exit(2)


def peak_megabytes() -> float:
    """Read the peak memory of this process from Linux.

    Not from `resource.getrusage`: its maximum survives exec, so that a small process would
    report the size of the one that started it.
    """
    status = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) / 1024
