"""`voz run --robot ros2`, as another program in the domain sees it."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from typing import Any

import pytest
from cyclonedds.sub import DataReader
from programs import Program, wait_until

from voz.ros2 import message_types as msg
from voz.ros2.node import Ros2Node
from voz.settings import Ros2

pytestmark = pytest.mark.realtime


def test_voz_run_tells_where_the_simulated_robot_is(voz: Callable[..., Program]) -> None:
    node = Ros2Node(Ros2())
    base, odom = (
        node.reader("cmd_vel", msg.TwistMessage),
        node.reader("odom", msg.Odometry),
    )
    run = voz("simulator,ros2")

    def arrived() -> bool:
        run.say("go forward")
        places = [message.pose.pose.position.x for message in odom.take(1000)]
        return bool(places) and places[-1] > 0.75

    wait_until(arrived)
    assert msg.velocity(0.1, 0.0) in base.take(1000)


def test_voz_run_says_once_that_nobody_listens(voz: Callable[..., Program]) -> None:
    run = voz("ros2", wait=0)
    run.say("go forward")
    events = run.wait_for(lambda event: event["type"] == "cmd_vel" and event["t"] >= 1)
    assert [event["text"] for event in events if event["type"] == "warning"] == [
        "the robot ros2 is lost (nobody listens to /cmd_vel): the robot stops"
    ]


def last_velocity(base: DataReader[Any]) -> Callable[[], float | None]:
    """Gives the last velocity that came to a base."""
    last: float | None = None

    def look() -> float | None:
        nonlocal last
        for message in base.take(1000):
            if isinstance(message, msg.TwistMessage):
                last = message.linear.x
        return last

    return look


def driving(voz: Callable[..., Program], *more: str) -> tuple[Program, Callable[[], float | None]]:
    """A run that drives a base, and the last velocity that came to that."""
    velocity = last_velocity(Ros2Node(Ros2()).reader("cmd_vel", msg.TwistMessage))
    run = voz("ros2", *more)

    def drives() -> bool:
        run.say("go forward")  # what it has not read yet would count later, as a new command
        run.wait_for(lambda event: event["type"] == "utterance")
        return velocity() == 0.1

    wait_until(drives)
    return run, velocity


def test_two_runs_on_one_topic_tell_of_each_other_and_not_of_their_watchdogs(
    voz: Callable[..., Program],
) -> None:
    base = Ros2Node(Ros2()).reader("cmd_vel", msg.TwistMessage)
    runs = [voz("ros2"), voz("ros2")]
    for run, other in (runs, reversed(runs)):
        events = run.wait_for(lambda event: "sends velocities" in event.get("text", ""))
        assert events[-1]["text"].startswith(f"process {other.process.pid} (")
        run.say("start speech")
        more = run.wait_for(lambda event: event["type"] == "cmd_vel" and event["t"] > 2)
        assert not [event for event in more if event["type"] == "warning"]
    del base


def test_a_run_that_is_killed_leaves_zero_behind(voz: Callable[..., Program]) -> None:
    run, velocity = driving(voz)
    run.process.kill()
    wait_until(lambda: velocity() == 0)


def test_a_run_that_is_suspended_is_stopped_and_goes_on_only_by_a_new_command(
    voz: Callable[..., Program],
) -> None:
    run, velocity = driving(voz)
    run.process.send_signal(signal.SIGSTOP)
    wait_until(lambda: velocity() == 0)
    time.sleep(1)
    run.process.send_signal(signal.SIGCONT)
    run.wait_for(lambda event: "control loop stalled for" in event.get("text", ""))
    for _ in range(5):  # beats, in which it may find its watchdog lost, and then stops once more
        assert run.wait_for(lambda event: event["type"] == "cmd_vel")[-1]["linear"] == 0
        assert velocity() == 0
    run.say("go back")
    wait_until(lambda: velocity() == -0.1)


def test_without_its_watchdog_a_base_hears_of_no_kill(voz: Callable[..., Program]) -> None:
    run, velocity = driving(voz, "--no-watchdog")
    run.process.kill()
    time.sleep(1.5)
    assert velocity() == 0.1  # so that it is the watchdog which the others test
