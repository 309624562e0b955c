"""A program of voz sets what it needs for its process; to import voz sets nothing."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys

import pytest
from calls import VOZ
from recordings import GO_BACK, ROOT

from voz.process.setup import is_out_of_memory

IMPORTED = "import os; before = dict(os.environ); import voz; print(dict(os.environ) == before)"
CALLED = "import os, voz.cli; voz.cli.main(['--version']); print(os.environ[{name!r}])"
THREADS = "OPENBLAS_NUM_THREADS"
NOBODY = """
import os, pwd
def unknown(*_): raise KeyError("uid not found")
pwd.getpwuid = unknown  # as in a container that runs with a number for its user
del os.environ["HOME"]
"""


def printed(program: str, **environment: str) -> list[str]:
    usual = {name: value for name, value in os.environ.items() if name != THREADS}
    done = subprocess.run(
        [sys.executable, "-c", program], env=usual | environment, capture_output=True, text=True
    )
    return done.stdout.split("\n")


def test_to_import_voz_changes_nothing() -> None:
    assert printed(IMPORTED) == ["True", ""]


def test_a_program_keeps_numpy_to_one_thread_unless_it_was_told_otherwise() -> None:
    called = CALLED.format(name=THREADS)
    assert printed(called)[1] == "1"
    assert printed(called, **{THREADS: "3"})[1] == "3"


def test_where_nobody_has_a_home_matplotlib_looks_for_none() -> None:
    called = CALLED.format(name="MPLCONFIGDIR")
    assert printed(NOBODY + called, MPLCONFIGDIR="")[1] == ""
    assert (
        printed(f"import os; os.environ.pop('MPLCONFIGDIR', None){NOBODY}{called}")[1] == os.devnull
    )


ALLOCATES = """
import ctypes
import numpy as np
from voz.process.setup import give_back_large_blocks

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
    command = [sys.executable, "-c", ALLOCATES.format(set_it=set_it)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout == f"{set_it}\n"


@pytest.mark.parametrize(
    ("arguments", "kilobytes"),
    [
        (["decode", GO_BACK], 100_000),
        (["run", "--listening"], 250_000),
        (["serve"], 250_000),
        (["devices"], 60_000),
    ],
)
def test_where_little_memory_is_allowed_one_line_says_so(
    arguments: list[object], kilobytes: int
) -> None:
    call = f"ulimit -v {kilobytes}; {shlex.join([*VOZ, *map(str, arguments)])}"
    done = subprocess.run(["sh", "-c", call], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert "memory" in line


def test_what_libraries_and_threads_say_of_it_is_known() -> None:
    assert is_out_of_memory(MemoryError())
    assert is_out_of_memory(ImportError("x.so: failed to map segment from shared object"))
    assert is_out_of_memory(RuntimeError("can't start new thread"))
    assert not is_out_of_memory(RuntimeError("a mistake"))
    assert not is_out_of_memory(ValueError("failed to map segment"))
