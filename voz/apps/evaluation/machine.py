"""Names the computer, for figures that depend on it."""

from __future__ import annotations

import os
import platform
from pathlib import Path

CPUINFO = Path("/proc/cpuinfo")
BOARD_MODEL = Path("/proc/device-tree/model")
"""The model of a small computer, as `Raspberry Pi 5 Model B Rev 1.0`."""


def machine() -> str:
    """The processor, its number of cores and the version of Python."""
    return f"{_processor()}, {os.cpu_count()} cores, Python {platform.python_version()}"


def _processor() -> str:
    if BOARD_MODEL.exists():
        return BOARD_MODEL.read_text().rstrip("\0\n")
    info = CPUINFO.read_text() if CPUINFO.exists() else ""
    models = [line.partition(": ")[2] for line in info.splitlines() if "model name" in line]
    return models[0] if models else platform.machine()
