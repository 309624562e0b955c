"""Large blocks of memory go back to the system at once, whatever was freed before."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
import ctypes
import numpy as np
from voz.process.memory import give_back_large_blocks

NAMES = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost"

class Usage(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in NAMES.split()]

libc = ctypes.CDLL(None)
libc.mallinfo2.restype = Usage
if {set_it}:
    give_back_large_blocks()
np.ones(16 << 20, np.uint8)  # freed at once: glibc learns from it
before = libc.mallinfo2().hblkhd
block = np.ones(8 << 20, np.uint8)
print(libc.mallinfo2().hblkhd - before >= 8 << 20)  # whether it is the system's own
"""


@pytest.mark.parametrize("set_it", [True, False])
def test_large_blocks_are_the_systems_own_if_that_is_set(set_it: bool) -> None:
    command = [sys.executable, "-c", PROGRAM.format(set_it=set_it)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == f"{set_it}\n"
