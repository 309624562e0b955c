"""What arrives and cannot be read: it is dropped, whatever it is, and the run goes on."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from programs import Program, wait_until

from voz.events import Notice, Twist
from voz.ros2 import Ros2Robot
from voz.ros2 import message_types as msg
from voz.ros2.node import Ros2Node
from voz.settings import Ros2

pytestmark = pytest.mark.usefixtures("domain")


def odometry(x: float) -> bytes:
    """An odometry as it is sent, from the nanoseconds of its time on; x in m."""
    pose = msg.PoseWithCovariance(msg.Pose(msg.Point(x), msg.Quaternion()))
    speed = msg.TwistWithCovariance(msg.velocity(0.1, 0.2))
    return bytes(msg.Odometry(msg.header("odom"), "base", pose, speed).serialize())[8:]


def malformed() -> Iterator[bytes]:
    whole = odometry(-1)
    yield whole.replace(b"odom\0", b"od\xf6m\0")  # Latin 1
    yield whole.replace(b"base\0", b"\xff\xff\xff\xff\0")
    yield whole[:4] + b"\xff\xff\xff\xff" + whole[8:]  # a name of 4 GB
    yield from (whole[:length] for length in range(0, len(whole), 40))
    chance = random.Random(1)
    for _ in range(30):
        yield chance.randbytes(chance.randrange(800))


def test_a_robot_drives_on_though_odometry_comes_that_cannot_be_read(
    own: Callable[..., Program],
) -> None:
    robot = Ros2Robot(Ros2(wait=0))
    robot.open()
    base = Ros2Node(Ros2()).reader("cmd_vel", msg.TwistMessage)
    driver = own("raw_peer.py")

    def arrives(x: float) -> bool:
        driver.say(odometry(x).hex())
        place = robot.place(0.0)
        return place is not None and place[0] == x

    wait_until(lambda: arrives(-1.0))
    for x, data in enumerate(malformed()):
        driver.say(data.hex())
        wait_until(lambda x=x: arrives(x))  # type: ignore[misc]
        robot.receive(Twist(0.0, 0.1, x))
        assert base.take(1) == [msg.velocity(0.1, x)]
    robot.close()


@pytest.mark.slow
@pytest.mark.parametrize("what", ["topic", "type"])
def test_a_program_with_names_that_cannot_be_read_hides_no_other(
    what: str, own: Callable[..., Program]
) -> None:
    own("nameless_peer.py", what=what).wait_for(lambda line: line.get("ready"))
    told: list[Notice] = []
    robot = Ros2Robot(Ros2(wait=0), told.append)
    robot.open()
    base: Any = Ros2Node(Ros2()).reader("cmd_vel", msg.TwistMessage)

    def found() -> bool:
        robot.receive(Twist(0.0, 0.1, 0.0))
        return any("listens to /cmd_vel" in notice.text for notice in told)

    wait_until(found)
    assert base.take(1) == [msg.velocity(0.1, 0.0)]
    robot.close()
