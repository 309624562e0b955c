"""The sources of PulseAudio or PipeWire, which PortAudio does not list."""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

PULSE_DEVICE = "pulse"
"""PortAudio's name of the sound server."""

SOURCE_VARIABLE = "PULSE_SOURCE"

PACTL_TIMEOUT = 2.0
"""Time for the server to answer, s; one that hangs never does."""

_LINE = re.compile(r"^\d+\t([^\t]+)\t.*?\b(\d+)ch (\d+)Hz", re.MULTILINE)


class PulseSource(NamedTuple):
    """A source, its number of channels and its rate, Hz."""

    name: str
    channels: int
    rate: int


def list_sources() -> list[PulseSource]:
    """The sources that `pactl` lists; none without it or without a server."""
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
    """Let streams that are opened in a `with` block record from a source; None changes nothing."""
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
