"""How a node's program ends, if a signal comes while it starts and the sound system hangs."""

from __future__ import annotations

import pytest
from recordings import ROOT
from ros1.ros import Ros

HANGS = """
import atexit, os, signal, threading, time
from voz.ros1.node_program import run_node

def work(node):
    threading.Thread(target=time.sleep, args=(600,), name="voz-hearing", daemon=True).start()
    os.kill(os.getpid(), signal.SIGTERM)  # not driving yet: it raises
    time.sleep(600)

atexit.register(time.sleep, 600)  # as PortAudio waits for a stream that is open
run_node("hanging", work)
"""


@pytest.mark.slow
def test_a_signal_while_it_starts_ends_it_though_the_sound_system_hangs(ros: Ros) -> None:
    done = ros.call(str(ROOT / "ros" / "python"), "-c", HANGS)
    assert (done.returncode, done.stderr) == (0, "")
