"""What a program of voz sets for its own process; to import voz sets nothing."""

from __future__ import annotations

import os
import sys

from voz.process.memory import give_back_large_blocks

SWITCH = 0.001
"""How long a thread waits for another to let go of Python, s; 5 ms as usual is seen in the beat."""


def set_up() -> None:
    """Prepare a process that may drive a robot for days; called before numpy is loaded.

    numpy gets no threads of its own, here and in child processes: matrices are small, and more
    threads wait for each other and take memory. Whoever wants it otherwise has set it already.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if os.path.expanduser("~") == "~":  # noqa: PTH111  # pathlib's raises an error
        # There is no home folder, of which matplotlib before 3.11 dies; this it can do without.
        os.environ.setdefault("MPLCONFIGDIR", os.devnull)
    sys.setswitchinterval(SWITCH)
    give_back_large_blocks()
