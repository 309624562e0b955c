"""S5 and S7 as a base on rclpy sees them: what arrives when voz ends, is killed or hangs."""

from __future__ import annotations

import signal
from collections.abc import Callable
from typing import Any

import pytest
from programs import Program

pytestmark = pytest.mark.realtime

FORWARD = {"linear": {"x": 0.1, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
STILL = {"linear": {"x": 0.0, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}

Start = Callable[..., Program]


def drives(line: dict[str, Any]) -> bool:
    return line.get("message") == FORWARD


def is_gone(line: dict[str, Any]) -> bool:
    return line.get("event") == "liveliness" and line["alive"] == 0


def test_a_program_that_is_ended_sends_zero_last(base: Start, voz: Start) -> None:
    node = base(deadline=0.5, lease=1.0)
    run = voz("ros2")
    run.say("go forward")
    node.wait_for(drives)
    run.end(signal.SIGTERM)
    lines = node.wait_for(is_gone)
    velocities = [line["message"] for line in lines if line.get("topic") == "cmd_vel"]
    assert velocities[-1] == STILL
    assert STILL not in velocities[:-1]


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
@pytest.mark.parametrize("manual", [False, True])
def test_a_base_is_told_of_a_program_that_is_killed_or_hangs(
    number: int, manual: bool, base: Start, voz: Start
) -> None:
    node = base(deadline=0.5, lease=1.0, manual=manual)
    run = voz("ros2", "--no-watchdog")
    run.say("go forward")
    node.wait_for(drives)
    run.process.send_signal(number)
    lines = node.wait_for(is_gone)
    events = [line["event"] for line in lines if "event" in line]
    assert "deadline" in events
    assert "incompatible" not in events


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
@pytest.mark.parametrize("manual", [False, True])
def test_the_watchdog_stops_a_base_whatever_it_asks_for(
    number: int, manual: bool, base: Start, voz: Start
) -> None:
    node = base(deadline=0.5, lease=1.0, manual=manual)
    run = voz("ros2")
    run.say("go forward")
    node.wait_for(drives)
    run.process.send_signal(number)
    lines = node.wait_for(lambda line: line.get("message") == STILL)
    assert "incompatible" not in [line.get("event") for line in lines]
