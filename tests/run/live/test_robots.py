"""Robots in a live run: one that is lost stops all, and a terminal shows the simulated one."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import time
from pathlib import Path

import pytest
from calls import VOZ
from live_robot import live_robot, moves, rests, warns

pytestmark = pytest.mark.slow

FICKLE = """
from pathlib import Path
from voz.robot.base import Robot

HERE = Path(__file__).parent

class Fickle(Robot):
    def receive(self, event):
        if (HERE / "block").exists():
            import time
            time.sleep(3600)
        if (HERE / "raise").exists():
            raise OSError("the cable is out")
    def lost(self):
        return "nobody answers" if (HERE / "lose").exists() else None
"""


@pytest.fixture
def fickle(tmp_path: Path, pulse: dict[str, str]) -> dict[str, str]:
    (tmp_path / "fickle_robot.py").write_text(FICKLE)
    folders = [str(tmp_path), os.environ.get("PYTHONPATH", "")]
    return pulse | {"PYTHONPATH": os.pathsep.join(folders)}


@pytest.mark.parametrize(
    ("what", "why"),
    [
        ("block", "does not take its events"),
        ("raise", "the cable is out"),
        ("lose", "nobody answers"),
    ],
)
def test_s5_a_robot_that_is_lost_stops_the_run_and_the_others_get_it(
    what: str, why: str, fickle: dict[str, str], tmp_path: Path
) -> None:
    name = "fickle_robot:Fickle"
    with live_robot(fickle, "--listening", "--robot", f"{name},console") as robot:
        robot.type("go forward")
        robot.wait_for(moves)
        (tmp_path / what).touch()
        lost = robot.wait_for(warns(f"the robot {name} is lost ("))
        assert why in lost.event["text"]
        assert lost.event["text"].endswith("): the robot stops")
        since = robot.arrived.index(lost)
        robot.wait_for(rests, since)
        robot.wait_for(
            lambda event: event["type"] == "cmd_vel" and event["t"] > lost.event["t"] + 1
        )
        assert not any(moves(arrived.event) for arrived in robot.arrived[since:])
        if what == "lose":
            (tmp_path / what).unlink()
            robot.wait_for(warns(f"{name} is there; the robot waits for a command"))
            since = len(robot.arrived)
            robot.type("go back")
            robot.wait_for(moves, since)
        assert robot.end() == 143
    assert rests(robot.of("cmd_vel")[-1])
    assert "stands still" in robot.words
    hangs = f"the robot {name} did not take its last velocity in time"
    assert (hangs in robot.words) == (what == "block")


def test_a_terminal_shows_the_simulated_room_beside_what_is_heard(pulse: dict[str, str]) -> None:
    ours, theirs = pty.openpty()
    with subprocess.Popen(
        [*VOZ, "run", "--no-sound", "--listening", "--robot", "simulator"],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        env=pulse | {"TERM": "xterm", "COLUMNS": "140", "LINES": "40"},
    ) as process:
        os.close(theirs)
        os.set_blocking(ours, False)
        shown = ""
        deadline = time.monotonic() + 30
        while not ("listening" in shown and any("\u2801" <= each <= "\u28ff" for each in shown)):
            assert process.poll() is None, shown
            assert time.monotonic() < deadline, shown
            try:
                shown += os.read(ours, 65536).decode(errors="replace")
            except BlockingIOError:
                time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == 143
    os.close(ours)
