"""Whether a process may use as much memory as it needs."""

from __future__ import annotations

import resource

from voz.errors import ConfigError

LEAST_MEMORY = 220_000
"""Address space, kB: with less OpenBLAS ends the process, and says so only to standard error."""

LIVE_MEMORY = 800_000
"""The same of a run with a microphone, whose threads have a stack of 8,192 each."""

NOT_LOADED = ("failed to map segment", "cannot allocate memory", "can't start new thread")
"""What a library or thread says for which there is no memory."""


def check_memory(kilobytes: int) -> None:
    """Raise ConfigError if `ulimit -v` allows less address space than that."""
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
