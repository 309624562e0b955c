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
from live_terminal import Terminal
from programs import PATIENCE, wait_until

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
        deadline = time.monotonic() + PATIENCE
        while not ("listening" in shown and any("\u2801" <= each <= "\u28ff" for each in shown)):
            assert process.poll() is None, shown
            assert time.monotonic() < deadline, shown
            try:
                shown += os.read(ours, 65536).decode(errors="replace")
            except BlockingIOError:
                time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 143
    os.close(ours)


PRINTS_EACH_MOVE = """
import voz


class Wheels(voz.Robot):
    def move(self, linear, angular):
        print(f"forward {linear} m/s, to the left {angular} rad/s")
"""


@pytest.mark.realtime
def test_what_robots_and_programs_print_stands_above_the_panel(
    tmp_path: Path, pulse: dict[str, str]
) -> None:
    (tmp_path / "wheels.py").write_text(PRINTS_EACH_MOVE)
    (tmp_path / "voz.toml").write_text(
        "[commands]\n\"point beer\" = { run = ['sh', '-c', 'echo \"\\033[2Jcheese\"'] }\n"
    )
    terminal = Terminal(pulse, tmp_path, "--robot", "wheels:Wheels")
    try:
        terminal.wait_for_velocity(0)
        terminal.type("point beer\rgo forward\r")
        wait_until(lambda: "sh: cheese" in terminal.rows())
        wait_until(lambda: sum("forward 0.1" in row for row in terminal.rows()) > 10)
        terminal.type("\x1b")
        terminal.wait_for_velocity(0)
        terminal.type("\x03")
        assert terminal.end() == 130
        seen, shown = terminal.rows(), terminal.look()
    finally:
        terminal.close()
    assert [sum(row.startswith(corner) for row in seen) for corner in "╭╰"] == [1, 1]
    assert "\x1b[2J" not in shown
    printed = [row for row in seen if "m/s, to the left" in row]
    assert "forward 0.1 m/s, to the left 0.0 rad/s" in printed
    assert all(row.startswith("forward ") and row.endswith(" rad/s") for row in printed)


def test_without_a_terminal_what_is_heard_is_seen_whatever_the_robot(
    fickle: dict[str, str],
) -> None:
    with live_robot(fickle, "--listening", "--robot", "fickle_robot:Fickle,simulator") as robot:
        robot.type("go forward")
        robot.wait_for(moves)
        robot.type("turn upside down")
        wait_until(lambda: "not a command" in robot.words)
    assert 'heard    "go forward" (1.00)' in robot.words
