"""How the program ends while a thread of its own is in a C library that does not let go."""

from __future__ import annotations

import atexit
import os
import threading

SOUND = ("voz-hearing", "voz-loudspeaker", "voz-renderer", "voz-speaker")
"""The threads that may be in the sound system's libraries."""


def lingering() -> bool:
    """Whether such a thread has not ended, though all that used it has."""
    return any(thread.name in SOUND for thread in threading.enumerate())


def end_by_force(code: int) -> None:
    """Let the program end with an exit code, whatever its threads do.

    It ends when all that is still to be saved is saved. Without this it would wait for PortAudio
    to be closed, for ever if a sound server hangs, or crash as the libraries that a thread is in
    are unloaded.
    """
    atexit.register(os._exit, code)
