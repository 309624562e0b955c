"""`voz doctor` with a real master, and real bases that stop by themselves and that do not."""

from __future__ import annotations

import json
import signal
from typing import Any

import pytest
from recordings import ROOT
from ros1.ros import Client, Program, Ros, eventually

pytestmark = pytest.mark.slow

BASE = "base stops"


def doctor(ros: Ros, *arguments: str) -> Program:
    program = str(ROOT / "ros" / "python")
    return ros.start(program, "-m", "voz", "doctor", "--robot", "ros1", "--json", *arguments)


def findings(program: Program) -> dict[str, dict[str, Any]]:
    assert program.wait() == 1  # there is no microphone, at the least
    found = [json.loads(line) for line in program.lines]
    return {one["what"]: one for one in found}


def base(ros: Ros, patience: float) -> Client:
    """A base, and what it hears."""
    ros.start("/usr/bin/python3", str(ROOT / "tests" / "ros1" / "base.py"), str(patience))
    client = ros.client("/cmd_vel", "/odom")
    eventually(lambda: client.of("/odom"))
    return client


def test_a_base_that_waits_for_velocities_is_well_and_is_not_moved(ros: Ros) -> None:
    client = base(ros, 0.5)
    found = findings(doctor(ros))
    assert found["ROS 1 master"]["well"]
    assert found["ROS 1 master"]["needed"]
    assert "/base" in found["ROS 1 /cmd_vel"]["told"]
    assert found["ROS 1 senders"]["well"]
    assert BASE not in found
    assert client.velocities() == []


def test_without_a_base_nobody_listens(ros: Ros) -> None:
    found = findings(doctor(ros))["ROS 1 /cmd_vel"]
    assert (found["well"], found["told"]) == (False, "nobody listens")


def test_without_a_master_it_says_where_it_looked(ros: Ros) -> None:
    ros.master.kill()
    found = findings(doctor(ros, "--base", "--yes"))
    assert f"127.0.0.1:{ros.port}" in found["ROS 1 master"]["told"]
    assert "there is no ROS master" in found[BASE]["told"]


@pytest.mark.realtime
def test_a_base_that_stops_by_itself_is_well_and_hears_zero_last(ros: Ros) -> None:
    client = base(ros, 0.4)
    found = findings(doctor(ros, "--base", "--yes"))[BASE]
    assert found["well"], found
    client.wait_for_velocity(0, 0)
    assert set(client.velocities()) == {(0, 0.2), (0, 0)}


def test_a_base_that_drives_on_is_told_of_and_hears_zero_last(ros: Ros) -> None:
    client = base(ros, 1000)
    found = findings(doctor(ros, "--base", "--yes"))[BASE]
    assert not found["well"]
    assert "drives on at 0.20 rad/s" in found["told"]
    assert "base_watchdog_ros1.py" in found["to_do"]
    client.wait_for_velocity(0, 0)


@pytest.mark.realtime
def test_the_simulator_of_the_package_stops_by_itself(ros: Ros) -> None:
    ros.node("simulator")
    client = ros.client("/odom")
    eventually(lambda: client.of("/odom"))
    assert findings(doctor(ros, "--base", "--yes"))[BASE]["well"]


def test_a_base_that_stands_whatever_it_is_told_is_told_of(ros: Ros) -> None:
    base(ros, 0)
    found = findings(doctor(ros, "--base", "--yes"))[BASE]
    assert not found["well"]
    assert "no motion" in found["told"]


@pytest.mark.realtime
def test_a_base_that_another_program_drives_is_left_alone(ros: Ros) -> None:
    client = base(ros, 0.5)
    ros.node("control_voz", "_sound:=none")
    eventually(client.velocities)
    found = findings(doctor(ros, "--base", "--yes"))
    assert found[BASE]["told"] == "velocities on /cmd_vel come from /control_voz too"
    senders = found["ROS 1 senders"]
    assert (senders["well"], senders["needed"]) == (False, False)
    assert senders["told"] == "velocities on /cmd_vel come from /control_voz"
    assert set(client.velocities()) == {(0, 0)}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_it_drives_ends_it_with_zero(ros: Ros, number: int) -> None:
    client = base(ros, 1000)
    program = doctor(ros, "--base", "--yes")
    client.wait_for_velocity(0, 0.2)
    program.process.send_signal(number)
    program.process.send_signal(number)  # somebody presses Ctrl-C again
    assert program.wait() == 128 + number
    client.wait_for_velocity(0, 0)
    assert "Traceback" not in program.text
