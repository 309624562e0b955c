"""`voz run --robot ros2`, as another program in the domain sees it."""

from __future__ import annotations

from collections.abc import Callable

from programs import Program, wait_until

from voz.config import Ros2
from voz.robot.ros2 import messages
from voz.robot.ros2.node import Node


def test_voz_run_tells_where_the_simulated_robot_is(voz: Callable[..., Program]) -> None:
    node = Node(Ros2())
    base, odom = node.reader("cmd_vel", messages.Twist), node.reader("odom", messages.Odometry)
    run = voz("simulator,ros2")

    def arrived() -> bool:
        run.say("go forward")
        places = [message.pose.pose.position.x for message in odom.take(1000)]
        return bool(places) and places[-1] > 0.75

    wait_until(arrived)
    assert messages.velocity(0.1, 0.0) in base.take(1000)


def test_voz_run_says_once_that_nobody_listens(voz: Callable[..., Program]) -> None:
    run = voz("ros2", wait=0)
    run.say("go forward")
    events = run.wait_for(lambda event: event["type"] == "cmd_vel" and event["t"] >= 1)
    assert [event["text"] for event in events if event["type"] == "warning"] == [
        "the robot ros2 is lost (nobody listens to /cmd_vel): the robot stops"
    ]
