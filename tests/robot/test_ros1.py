"""A robot on ROS 1 for whoever hands it events; the nodes are tested in `tests/ros1`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from recordings import ROOT
from ros1.ros import Program, Ros, eventually, running_ros

PROGRAM = """
import sys, time
from voz.config import Ros1
from voz.errors import RobotError
from voz.events import *
from voz.config import Simulator
from voz.robot.ros1 import Ros1Robot
from voz.robot.simulator import SimulatedRobot

robot = Ros1Robot(
    Ros1(node="own", selected_object="arm"),
    arguments=["cmd_vel:=/base"],
    where=SimulatedRobot(Simulator(start=(1.0, 0.5, 0.0))).state_at,
)
try:
    robot.open()
except RobotError as error:
    sys.exit(str(error))
events = {
    "forward": Twist(0, 0.1, 0.05),
    "beer": SelectedObject(0, 1),
    "heard": Utterance(0, "go back", 0.9, True, 0, 1, "text"),
    "refused": Utterance(0, "go home", 0.2, False, 0, 1, "text"),
}
for line in sys.stdin:
    robot.receive(events[line.strip()])
    print(robot.lost())
robot.close()
"""


@pytest.fixture
def ros(tmp_path: Path) -> Iterator[Ros]:
    with running_ros(tmp_path) as ros:
        yield ros


def robot(ros: Ros) -> Program:
    return ros.start(str(ROOT / "ros" / "python"), "-c", PROGRAM)


def test_it_publishes_what_is_obeyed_and_zero_velocity_last(ros: Ros) -> None:
    client = ros.client("/base", "/arm", "/recognizer/output", "/odom")
    driven = robot(ros)

    def arrives() -> bool:
        driven.type("forward")
        return bool(client.velocities("/base"))

    eventually(arrives)
    for event in ("beer", "refused", "heard", "forward"):
        driven.type(event)
    driven.process.stdin.close()
    assert driven.wait() == 0
    client.wait_for_velocity(0, 0, "/base")
    assert set(client.velocities("/base")) == {(0.1, 0.05), (0, 0)}
    assert client.of("/arm") == [{"data": 1}]
    assert client.of("/odom")[-1]["pose"]["pose"]["position"] == {"x": 1.0, "y": 0.5, "z": 0.0}
    assert client.of("/recognizer/output") == [{"data": "go back"}]


def test_it_says_that_the_master_is_lost_and_lets_nothing_move(ros: Ros) -> None:
    client = ros.client("/base")
    driven = robot(ros)

    def arrives() -> bool:
        driven.type("forward")
        return bool(client.velocities("/base"))

    eventually(arrives)
    assert "None\n" in driven.text
    ros.master.kill()

    def is_lost() -> bool:
        driven.type("forward")
        return "does not answer" in driven.text

    eventually(is_lost)
    driven.type("forward")
    client.wait_for_velocity(0, 0, "/base")


def test_without_a_master_it_cannot_be_opened(ros: Ros) -> None:
    ros.master.kill()
    done = robot(ros)
    assert done.wait() == 1
    assert done.text.startswith("there is no ROS master at http://127.0.0.1")
