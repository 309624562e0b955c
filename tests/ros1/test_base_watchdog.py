"""The example for bases that drive on when no velocity comes any more."""

from __future__ import annotations

import os
import signal

import pytest
from recordings import ROOT
from ros1.ros import Client, Program, Ros, eventually
from ros1.test_always_stops import children
from ros1.test_control_voz_node import connect

TWIST = {
    "type": "geometry_msgs/Twist",
    "definition": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"
    + "=" * 80
    + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n",
}
DRIVING = [(0.2, 0.0), (0.1, -0.3)]


@pytest.fixture
def watchdog(ros: Ros) -> Program:
    example = str(ROOT / "examples" / "base_watchdog_ros1.py")
    return ros.start("/usr/bin/python3", example, "base_cmd_vel:=/wheels")


@pytest.fixture
def base(ros: Ros, watchdog: Program) -> Client:
    """What the base hears; nobody has sent a velocity yet."""
    client = ros.client("/wheels")
    eventually(lambda: client.velocities("/wheels"))
    return client


def drive(client: Client, linear: float, angular: float) -> None:
    """Send a velocity again and again until it arrives."""
    vectors = {"linear": {"x": linear, "y": 0, "z": 0}, "angular": {"x": 0, "y": 0, "z": angular}}

    def arrives() -> bool:
        client.publish("/cmd_vel", data=vectors, **TWIST)
        return (linear, angular) in client.velocities("/wheels")

    eventually(arrives)


@pytest.mark.slow
def test_what_comes_is_passed_on_and_when_nothing_comes_the_base_gets_zero(base: Client) -> None:
    for velocity in DRIVING:
        drive(base, *velocity)
    base.wait_for_velocity(0, 0, "/wheels")
    drive(base, 0.3, 0.0)  # and it goes on when they come again
    base.wait_for_velocity(0, 0, "/wheels")


@pytest.mark.slow
def test_the_last_it_sends_is_zero(base: Client, watchdog: Program) -> None:
    drive(base, 0.2, 0.0)
    watchdog.process.terminate()
    assert watchdog.wait() == 0
    base.wait_for_velocity(0, 0, "/wheels")
    assert "Traceback" not in watchdog.text


@pytest.mark.realtime
def test_voz_that_is_killed_together_with_its_own_watchdog_is_stopped(
    ros: Ros, base: Client
) -> None:
    node = ros.node("control_voz", "_sound:=none", "_listening:=true")
    connect(base, node)
    base.say("go forward")
    base.wait_for_velocity(0.1, 0, "/wheels")
    for process in (node.process.pid, *children(node)):
        os.kill(process, signal.SIGKILL)
    base.wait_for_velocity(0, 0, "/wheels")
