"""Keeps the memory of a long run flat."""

from __future__ import annotations

M_MMAP_THRESHOLD = -3
"""The number of this setting in glibc's `malloc.h`."""

LARGE = 64 * 1024
"""Bytes; what is computed from an utterance is larger, most else is smaller."""


def give_back_large_blocks() -> None:
    """Let large blocks of memory go back to the system as soon as they are free.

    glibc learns from the largest ones to keep them for later instead, in pieces: a run that listens
    then takes up to 2 MB more or less from minute to minute. It costs no measurable time.
    """
    import ctypes  # only now: signals that come while a program's imports go on are told late

    libc = ctypes.CDLL(None)
    if hasattr(libc, "mallopt"):  # other libraries have no such setting
        libc.mallopt(M_MMAP_THRESHOLD, LARGE)
