"""What a program of voz sets for its own process; to import voz sets nothing."""

from __future__ import annotations

import os


def set_up() -> None:
    """Let numpy, which is not loaded yet, have no threads of its own, here and in child processes.

    Matrices are small here: more threads wait for each other and take memory. Whoever wants it
    otherwise has set it already.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
