"""How the program ends when the sound system does not let go."""

from __future__ import annotations

import atexit
import os

from voz.signals import exit_code

FAILED = 1
"""The exit code of a program that ends by an error that nobody expected."""


def end_by_force(error: BaseException | None) -> None:
    """Let the program end though a thread hangs in the sound system.

    It ends when all that is still to be saved is saved. Without this it would wait for PortAudio
    to be closed, for ever, or crash as the libraries that the thread is in are unloaded.

    Args:
        error: what ends the program, with its exit code, if it was no signal.
    """
    code = error.code if isinstance(error, SystemExit) else exit_code()
    atexit.register(os._exit, code if isinstance(code, int) else FAILED)
