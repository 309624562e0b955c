"""A program of voz sets what it needs for its process; to import voz sets nothing."""

from __future__ import annotations

import os
import subprocess
import sys

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
