"""The sources of a sound server, PulseAudio or PipeWire. An edge: PortAudio does not name them."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

PULSE_DEVICE = "pulse"
"""PortAudio's name of the server, of whose sources the environment chooses one."""

SOURCE_VARIABLE = "PULSE_SOURCE"

PACTL_TIMEOUT = 2.0
"""For the server to answer, s; one that hangs never does."""

_LINE = re.compile(r"^\d+\t([^\t]+)\t.*?\b(\d+)ch (\d+)Hz", re.MULTILINE)


class PulseSource(NamedTuple):
    """A source: its name, how many channels it has, its rate, Hz."""

    name: str
    channels: int
    rate: int


def list_sources() -> list[PulseSource]:
    """Ask `pactl`; there are none without it, or where no server answers."""
    try:
        done = subprocess.run(
            ["pactl", "list", "short", "sources"],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=PACTL_TIMEOUT,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return []
    return [
        PulseSource(name, int(channels), int(rate))
        for name, channels, rate in _LINE.findall(done.stdout)
    ]


@contextmanager
def pulse_source_selected(source: str | None) -> Iterator[None]:
    """Let the server record from one of its sources what is opened in a `with` block.

    Args:
        source: its name; None leaves the choice as it is.
    """
    if source is None:
        yield
        return
    before = os.environ.get(SOURCE_VARIABLE)
    os.environ[SOURCE_VARIABLE] = source
    try:
        yield
    finally:
        if before is None:
            del os.environ[SOURCE_VARIABLE]
        else:
            os.environ[SOURCE_VARIABLE] = before
