"""What a process of voz needs: settings, which importing voz does not make, and memory."""

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


LEAST_MEMORY = 220_000
"""Address space, kB: with less OpenBLAS ends the process, and says so only to standard error."""

LIVE_MEMORY = 800_000
"""The same of a run with a microphone, whose threads have a stack of 8,192 each."""

NOT_LOADED = ("failed to map segment", "cannot allocate memory", "can't start new thread")
"""What a library or thread says for which there is no memory."""


def check_memory(kilobytes: int) -> None:
    """Raise ConfigError if `ulimit -v` allows less address space than that."""
    import resource  # neither at the top: signals wait for imports

    from voz.errors import ConfigError

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < kilobytes * 1024:
        allowed = f"only {limit // 1024:,} kB of memory may be used"
        raise ConfigError(f"{allowed}; allow {kilobytes:,} by `ulimit -v`, or all")


def is_out_of_memory(error: BaseException) -> bool:
    """Whether an error means that there is no more memory."""
    text = str(error).lower()
    return isinstance(error, MemoryError) or (
        isinstance(error, ImportError | RuntimeError) and any(each in text for each in NOT_LOADED)
    )
