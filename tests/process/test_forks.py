"""What a user's code forks: it drives nothing, and keeps no motion alive."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from programs import PATIENCE, wait_until
from promises.real_run import watched

pytestmark = pytest.mark.slow


def test_what_a_robot_forks_ends_where_it_comes_back_and_only_one_drives(
    tmp_path: Path, pulse: dict[str, str]
) -> None:
    with watched(tmp_path, pulse) as run:
        (tmp_path / "fault").write_text("os.fork()")
        run.drive()
        run.type(b"stop\n")
        run.wait_for("0.0")
        run.stands_from_now_on()
        run.type(b"go back\n")
        run.wait_for("-0.1")
        run.end()
    assert len({process for process, _ in run.noted()}) == 1
    assert "is lost" not in (tmp_path / "events.jsonl").read_text()


def test_children_of_the_robot_and_of_the_run_that_live_on_keep_no_motion_alive(
    tmp_path: Path, pulse: dict[str, str]
) -> None:
    settings = '[commands]\n"point beer" = { call = ["own_robots:fork_and_live"] }\n'
    (tmp_path / "voz.toml").write_text(settings)
    with watched(tmp_path, pulse) as run:
        (tmp_path / "fault").write_text("fork_and_live()")
        run.type(b"point beer\n")
        run.drive()
        children = tmp_path / "children"
        wait_until(lambda: children.exists() and children.read_text().count("\n") == 2)
        run.process.kill()
        run.is_left_with_zero()


IN_A_LOOP = """
with voz.Controller([receive], listening=True) as controller:
    controller.hear(FORWARD)
    controller.send(0.1)
    child = os.fork()
    try:
        for beat in range(2, 9):
            controller.send(beat / 10)
            time.sleep(0.01)
    except voz.RobotError as error:
        tell(error)
if child:
    os.waitpid(child, 0)
"""

IN_A_RECEIVER = """
def heard():
    yield FORWARD
    time.sleep(0.5)

with voz.Controller([receive, forks], listening=True) as controller:
    controller.run(heard())
"""

IN_A_ROBOT = """
class Wheels(voz.Robot):
    def receive(self, event):
        receive(event)
        forks(event)

with voz.Controller(Wheels(), listening=True) as controller:
    controller.hear(FORWARD)
    for beat in range(1, 9):
        controller.send(beat / 10)
        time.sleep(0.05)
"""


@pytest.mark.parametrize("program", [IN_A_LOOP, IN_A_RECEIVER, IN_A_ROBOT])
def test_what_a_program_with_a_controller_forks_does_not_drive(
    program: str, tmp_path: Path
) -> None:
    head = """
import os, time, voz, voz.events
FORWARD = voz.Utterance(0, "go forward", 1.0, True, 0, 0, "test")
done = []

def tell(what):
    os.write(1, f"{what}\\n".encode())

def receive(event):
    if isinstance(event, voz.events.Twist):
        tell(f"{os.getpid()} {event.linear}")

def forks(event):
    if not done and isinstance(event, voz.events.Twist) and event.linear:
        done.append(1)
        os.fork()
"""
    command = [sys.executable, "-W", "ignore", "-c", head + program]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as it:
        told, _ = it.communicate(timeout=PATIENCE)  # until no child has its output any more
        assert it.returncode == 0
    lines = told.splitlines()
    sent = [line.split() for line in lines if line[0].isdigit()]
    assert {process for process, _ in sent} == {str(it.pid)}
    assert [velocity for _, velocity in sent].count("0.1") > 3
    assert sent[-1] == [str(it.pid), "0.0"]
    refused = [line for line in lines if not line[0].isdigit()]
    assert all("a forked process does not drive" in line for line in refused)
    assert len(refused) == (program == IN_A_LOOP)
