"""The program ends with its own exit code even if a thread never does."""

from __future__ import annotations

import subprocess
import sys

import pytest

HANGS = """
import atexit, sys, threading, time
from voz.live.ending import end_by_force
atexit.register(time.sleep, 60)  # as PortAudio waits for a server that hangs
try:
    {ends}
except BaseException as error:
    end_by_force(error)
    raise
finally:
    print("all is saved", flush=True)
"""


@pytest.mark.parametrize(
    ("ends", "code"), [("sys.exit(130)", 130), ("raise KeyError", 1), ("sys.exit('why')", 1)]
)
def test_all_is_saved_and_the_exit_code_is_that_of_what_ended_it(ends: str, code: int) -> None:
    done = subprocess.run(
        [sys.executable, "-c", HANGS.format(ends=ends)],
        capture_output=True,
        text=True,
        timeout=30,
    )
    assert done.returncode == code
    assert done.stdout == "all is saved\n"
