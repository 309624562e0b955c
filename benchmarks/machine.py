"""What every benchmark prints or needs: which machine it ran on, and its peak memory."""

from __future__ import annotations

from pathlib import Path

from voz.apps.evaluation.machine import machine as machine


def peak_megabytes() -> float:
    """Read the peak memory of this process from Linux.

    Not from `resource.getrusage`: its maximum survives exec, so that a small process would
    report the size of the one that started it.
    """
    status = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) / 1024
