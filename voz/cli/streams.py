"""Standard input, output and errors: always there, and never a reason for more than one line."""

from __future__ import annotations

import os
import sys
from io import TextIOWrapper

NAMES = ("stdin", "stdout", "stderr")


def open_streams() -> None:
    """Make the three standard streams usable, whatever the caller has closed.

    What is opened next would else get the number of a closed one, and be written over by what is
    printed.
    """
    for number, name in enumerate(NAMES):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free: this one
            os.set_inheritable(number, True)
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, "w" if number else "r", closefd=False))  # noqa: SIM115
    # A file name may hold what the terminal cannot show, and typed text what is no text.
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace" if stream is sys.stdin else "backslashreplace")


def let_go_of_streams() -> None:
    """Drop what cannot be written; else Python complains of it after the last line."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)
