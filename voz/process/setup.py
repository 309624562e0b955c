"""Settings of a process that runs voz; importing voz sets nothing."""

from __future__ import annotations

import os
import sys

SWITCH_INTERVAL = 0.001
"""Python's thread switch interval, s; the usual 5 ms make the control loop late."""

M_MMAP_THRESHOLD = -3
"""The number of this setting in glibc's `malloc.h`."""

LARGE_BLOCK = 64 * 1024
"""Bytes; the arrays of an utterance are larger, most other blocks are smaller."""


def set_up() -> None:
    """Prepare a process that may drive a robot for days; called before numpy is imported.

    numpy computes on one thread, here and in child processes, unless the user has set it otherwise:
    the matrices are small, and more threads wait for each other.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if os.path.expanduser("~") == "~":  # noqa: PTH111  # pathlib's raises an error
        # matplotlib before 3.11 fails without a home folder.
        os.environ.setdefault("MPLCONFIGDIR", os.devnull)
    sys.setswitchinterval(SWITCH_INTERVAL)
    give_back_large_blocks()


def give_back_large_blocks() -> None:
    """Let glibc return large blocks of memory to the system as soon as they are free.

    Else the memory of a long run goes up and down by 2 MB. It costs no measurable time.
    """
    import ctypes  # not at the top: signals wait for imports

    libc = ctypes.CDLL(None)
    if hasattr(libc, "mallopt"):  # other C libraries have no such setting
        libc.mallopt(M_MMAP_THRESHOLD, LARGE_BLOCK)
