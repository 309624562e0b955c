"""`voz doctor` with bases on ROS 2 that stop by themselves and that do not."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from calls import HANGS, VOZ, in_process
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy
from programs import PATIENCE, Program, wait_until

from voz.apps.doctor.base_stop_check import MeasuredMotion
from voz.apps.doctor.ros2_checks import Ros2Base
from voz.ros2 import message_types as msg
from voz.ros2.node import Ros2Node
from voz.settings import Ros2

pytestmark = [pytest.mark.usefixtures("domain"), pytest.mark.slow]

BASE = "base stops"
DRIVE = ["--base", "--yes"]


@pytest.fixture
def start(programs: Callable[..., Program]) -> Callable[[float], Program]:
    """Starts a base with a patience, s."""

    def begin(patience: float) -> Program:
        program = programs(Path(sys.executable), "base.py", patience=patience)
        program.wait_for(lambda line: line.get("ready"))
        return program

    return begin


def findings(*arguments: str) -> dict[str, dict[str, Any]]:
    result = in_process("doctor", "--robot", "ros2", "--json", *arguments)
    assert result.code == 1  # there is no microphone, at the least
    return {one["what"]: one for one in result.json}


def test_a_base_that_listens_is_well_and_is_not_moved(start: Callable[[float], Program]) -> None:
    base = start(0.5)
    found = findings()
    assert found["ROS 2"]["well"]
    assert found["ROS 2 /cmd_vel"]["well"]
    assert found["ROS 2 senders"]["well"]
    assert BASE not in found
    assert base.is_silent


def test_a_base_that_stops_by_itself_is_well_and_hears_zero_last(
    start: Callable[[float], Program],
) -> None:
    base = start(0.4)
    found = findings(*DRIVE)[BASE]
    assert found["well"], found
    heard = base.wait_for(lambda line: line["angular"] == 0)
    assert [line["angular"] for line in heard] == [0.2] * (len(heard) - 1) + [0]


def test_without_a_base_nobody_listens_and_nothing_is_driven(tmp_path: Path) -> None:
    (settings := tmp_path / "voz.toml").write_text("[ros2]\nwait = 0.2\n")
    found = findings(*DRIVE, "--config", str(settings))
    assert found["ROS 2 /cmd_vel"]["told"] == "nobody listens"
    assert found[BASE]["told"] == "nobody listens to /cmd_vel"


def test_a_base_that_another_program_drives_is_left_alone(
    start: Callable[[float], Program],
) -> None:
    base = start(0.5)
    other = Ros2Node(Ros2()).writer("cmd_vel", msg.TwistMessage)
    found = findings(*DRIVE)
    assert found[BASE]["told"].startswith("velocities on /cmd_vel come from process ")
    senders = found["ROS 2 senders"]
    assert f"process {os.getpid()} " in senders["told"]
    assert (senders["well"], senders["needed"]) == (False, False)
    assert base.is_silent
    del other


def test_ctrl_c_while_it_drives_ends_it_with_zero(start: Callable[[float], Program]) -> None:
    base = start(1000)
    command = [*VOZ, "doctor", "--robot", "ros2", *DRIVE]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        base.wait_for(lambda line: line["angular"] == 0.2)
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=PATIENCE)
    assert process.returncode == 128 + signal.SIGINT
    assert complaint == b""
    base.wait_for(lambda line: line["angular"] == 0)


def test_an_odometry_that_promises_nothing_is_read_too() -> None:
    node = Ros2Node(Ros2())
    qos = node.qos(msg.Odometry, reliability=Policy.Reliability.BestEffort)
    odom = DataWriter(node.participant, node.topic("odom", msg.Odometry), qos)
    base = Ros2Base(Ros2(), "odom", lambda: 5.0)
    pose = msg.PoseWithCovariance(msg.Pose(msg.Point(), msg.Quaternion()))
    speed = msg.TwistWithCovariance(msg.velocity(0.1, 0.2))
    told = msg.Odometry(msg.header("odom"), "base", pose, speed)

    def arrives() -> object:
        odom.write(told)
        return base.motion()

    wait_until(arrives)
    assert base.motion() == MeasuredMotion(5.0, 0.1, 0.2)


def test_without_cyclonedds_it_says_how_to_install_it() -> None:
    code = "import sys; sys.modules['cyclonedds'] = None\n" + VOZ[-1]
    done = subprocess.run(
        [*VOZ[:-1], code, "doctor", "--robot", "ros2", "--json"],
        capture_output=True,
        text=True,
        timeout=HANGS,
    )
    found = [json.loads(line) for line in done.stdout.splitlines()]
    (ros2,) = [one for one in found if one["what"] == "ROS 2"]
    assert not ros2["well"]
    assert "[ros2]" in ros2["to_do"]
