"""A robot that works for long at an event gets its velocities all the same."""

from __future__ import annotations

import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from calls import in_process
from programs import wait_until

from voz.events import Reply, SelectedObject, Twist
from voz.robot.base import Robot
from voz.robot.factory import make_user_robot
from voz.robot.mailbox import EVENT_TIMEOUT, MAX_MAILBOX_EVENTS, Mailbox
from voz.robot.robot_process import RobotProcess, RobotSpec

MODULE = """
import time
from pathlib import Path
from voz.events import SelectedObject, Reply, Twist, Utterance
from voz.robot.base import Robot

class Arm(Robot):
    slow = True
    def open(self):
        self.log = open("log", "w", buffering=1)
    def receive(self, event):
        if isinstance(event, Twist):
            self.log.write(f"{event.linear}\\n")
        elif isinstance(event, SelectedObject):
            self.log.write("works\\n")
            while not Path("done").exists():
                time.sleep(0.01)
            self.log.write(f"has {event.value}\\n")
        elif isinstance(event, Reply):
            raise OSError(event.text)
        elif isinstance(event, Utterance):
            self.log.write(f"{event.text} works\\n")
            time.sleep(3)
    def close(self):
        self.log.write("closed\\n")
        self.log.close()
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "arms.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "arms", raising=False)


def apart() -> Robot:
    return RobotProcess(RobotSpec("arms:Arm"), print)


def here_too() -> Robot:
    return make_user_robot("arms:Arm", {})


@contextmanager
def boxed(robot: Robot) -> Iterator[Mailbox]:
    try:
        with Mailbox("arm", robot) as box:
            yield box
    finally:
        if isinstance(robot, RobotProcess):
            robot.end()


def got() -> list[str]:
    return Path("log").read_text().splitlines()


def drive(box: Mailbox, linear: float) -> None:
    box.receive(Twist(0.0, linear, 0.0))
    time.sleep(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("make", [apart, here_too])
def test_while_it_works_velocities_go_on_and_a_stop_comes(make: Callable[[], Robot]) -> None:
    with boxed(make()) as box:
        box.receive(SelectedObject(0.0, 1))
        wait_until(lambda: "works" in got())
        wait_until(lambda: drive(box, 0.1) or "0.1" in got())
        time.sleep(2 * EVENT_TIMEOUT)
        wait_until(lambda: drive(box, 0.0) or got()[-1] == "0.0")
        wait_until(lambda: drive(box, 0.0) or box.lost() is None)
        assert "has 1" not in got()
        Path("done").touch()
        wait_until(lambda: got()[-1] == "has 1")
    assert got()[-1] == "closed"
    assert not box.hangs


@pytest.mark.parametrize("make", [apart, here_too])
def test_work_comes_one_after_the_other_and_what_waits_is_done_at_the_end(
    make: Callable[[], Robot],
) -> None:
    with boxed(make()) as box:
        for number in (1, 2, 100):
            box.receive(SelectedObject(0.0, number))
        wait_until(lambda: "works" in got())
        Path("done").touch()
    assert [line for line in got() if line != "works"] == ["has 1", "has 2", "has 100", "closed"]


@pytest.mark.realtime
def test_work_that_never_ends_does_not_keep_the_run_from_its_end() -> None:
    with boxed(apart()) as box:
        box.receive(SelectedObject(0.0, 1))
        wait_until(lambda: "works" in got())
        drive(box, 0.0)
    assert not box.hangs
    assert got() == ["works", "0.0", "closed"]


@pytest.mark.parametrize("make", [apart, here_too])
def test_what_its_work_raises_loses_it_and_it_is_stopped(make: Callable[[], Robot]) -> None:
    with boxed(make()) as box:
        drive(box, 0.1)
        box.receive(Reply(0.0, "the gripper is jammed"))
        wait_until(lambda: drive(box, 0.1) or box.lost())
        assert "the gripper is jammed (arms.py, line 20)" in (box.lost() or "")
        drive(box, 0.1)
        wait_until(lambda: got()[-1] == "0.0")


def test_what_its_work_raised_does_not_grow_as_it_is_raised_again_and_again() -> None:
    robot = here_too()
    robot.open()
    robot.receive(Reply(0.0, "the gripper is jammed"))

    def frames() -> int:
        try:
            robot.receive(Twist(0.0, 0.1, 0.0))
        except OSError as error:
            return len(traceback.extract_tb(error.__traceback__))
        return 0

    wait_until(frames)
    assert len({frames() for _ in range(10)}) == 1
    assert got()[-1] == "0.0"
    robot.close()


def test_too_much_work_loses_it_until_some_is_done() -> None:
    with boxed(here_too()) as box:
        for _ in range(2 * MAX_MAILBOX_EVENTS):
            box.receive(SelectedObject(0.0, 1))
            time.sleep(0.001)
        wait_until(lambda: "cannot keep up" in (box.lost() or ""))
        Path("done").touch()
        wait_until(lambda: got().count("has 1") >= MAX_MAILBOX_EVENTS)
        wait_until(lambda: drive(box, 0.0) or box.lost() is None)


@pytest.mark.realtime
def test_a_run_drives_and_stops_a_robot_that_sleeps_at_each_command(tmp_path: Path) -> None:
    typed = tmp_path / "typed.txt"
    typed.write_text("start speech\ngo forward\n" + "-\n" * 10 + "stop\n" + "-\n" * 5)
    result = in_process("run", "--text", typed, "--no-sound", "--robot", "arms:Arm", cwd=tmp_path)
    assert result.code == 0
    assert "start speech works" in got()
    assert "0.1" in got()
    assert got()[-2:] == ["0.0", "closed"]
