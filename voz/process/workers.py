"""What a process sets for itself that works for another one, and has no life of its own."""

from __future__ import annotations

import os
import signal
from contextlib import ExitStack

from voz.process.quiet_libraries import quiet_libraries
from voz.process.setup import set_up

PR_SET_PDEATHSIG = 1
"""The number of this setting in Linux's `prctl.h`."""

_UNTIL_THE_END = ExitStack()


def begin_worker(parent: int | None = None) -> None:
    """Leave Ctrl-C, which reaches all processes, to the one that started it, and stderr to it.

    Args:
        parent: the process that it must not outlive, however that ends; None if it may.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    set_up()
    if parent is not None:
        _end_with(parent)
    _UNTIL_THE_END.enter_context(quiet_libraries())


def _end_with(parent: int) -> None:
    import ctypes

    libc = ctypes.CDLL(None)
    if hasattr(libc, "prctl"):  # elsewhere a worker notices that nobody asks any more
        libc.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            os._exit(1)
