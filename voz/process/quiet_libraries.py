"""Keeps what C libraries write to standard error out of sight."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from voz.process.ending import lingering


@contextmanager
def quiet_libraries() -> Iterator[None]:
    """Let nobody but Python write to standard error for the length of a `with` block.

    Of a lost microphone ALSA and PortAudio write ten lines at each attempt to open it anew, in the
    midst of the display, and libmpg123 as many of a damaged recording.
    """
    try:
        theirs = sys.stderr.fileno()
    except (AttributeError, OSError, ValueError):  # there is none, or it is no file
        yield
        return
    before = sys.stderr
    before.flush()
    ours = os.fdopen(os.dup(theirs), "w", buffering=1, errors="backslashreplace")
    with open(os.devnull, "w") as nowhere:  # noqa: PTH123
        os.dup2(nowhere.fileno(), theirs)
    sys.stderr = ours
    try:
        yield
    finally:
        ours.flush()
        if not lingering():  # else it would be heard now, in the midst of the last lines
            sys.stderr = before
            os.dup2(ours.fileno(), theirs)
            ours.close()
