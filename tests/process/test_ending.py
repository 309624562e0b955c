"""The program ends with its own exit code even if a thread never does."""

from __future__ import annotations

import subprocess
import sys

HANGS = """
import atexit, sys, threading, time
from voz.process.ending import end_by_force, lingering
atexit.register(time.sleep, 60)  # as PortAudio waits for a server that hangs
assert not lingering()
threading.Thread(target=time.sleep, args=(60,), name="voz-hearing", daemon=True).start()
if lingering():
    end_by_force(130)
try:
    sys.exit(5)
finally:
    print("all is saved", flush=True)
"""


def test_all_is_saved_and_the_exit_code_is_that_of_what_ended_it() -> None:
    done = subprocess.run([sys.executable, "-c", HANGS], capture_output=True, text=True, timeout=30)
    assert done.returncode == 130
    assert done.stdout == "all is saved\n"
