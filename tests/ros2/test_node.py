"""What arrives and cannot be read: it is dropped, whatever it is, and the run goes on."""

from __future__ import annotations

import gc
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from programs import Program, wait_until

from voz.errors import ConfigError
from voz.events import Notice, Twist
from voz.ros2 import Ros2Robot
from voz.ros2 import message_types as msg
from voz.ros2.node import Ros2Node, cyclone_settings, domain_number
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


def test_nodes_left_in_a_circle_of_objects_are_gone_and_the_domain_can_be_joined_again() -> None:
    for _ in range(10):
        circle: list[Any] = []
        for node in (Ros2Node(Ros2()), Ros2Node(Ros2())):
            circle += [node.reader("odom", msg.Odometry), node.writer("odom", msg.Odometry)]
        circle.append(circle)
        del circle, node
        gc.collect()
    Ros2Node(Ros2())


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


def settings(**environment: str) -> ElementTree.Element:
    own, end, rest = cyclone_settings(environment).partition("</CycloneDDS>,")
    assert rest == environment.get("CYCLONEDDS_URI", "")
    return ElementTree.fromstring(own + end.rstrip(","))


def peers(tree: ElementTree.Element) -> list[str | None]:
    return [peer.get("address") for peer in tree.iter("Peer")]


def test_the_domain_is_that_of_the_settings_or_the_environment_or_0() -> None:
    assert domain_number(Ros2(domain=7), {"ROS_DOMAIN_ID": "8"}) == 7
    assert domain_number(Ros2(), {"ROS_DOMAIN_ID": "8"}) == 8
    assert domain_number(Ros2(), {"ROS_DOMAIN_ID": ""}) == 0
    assert domain_number(Ros2(), {}) == 0


@pytest.mark.parametrize("said", ["-1", "233", "one", "1.5", "²", "9" * 5000])
def test_a_domain_that_cannot_be_is_refused(said: str) -> None:
    with pytest.raises(ConfigError, match=r"^ROS_DOMAIN_ID is .{,60} 0 to 232"):
        domain_number(Ros2(), {"ROS_DOMAIN_ID": said})


@pytest.mark.parametrize(
    "environment",
    [
        {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"},
        {"ROS_LOCALHOST_ONLY": "1"},
        {"ROS_LOCALHOST_ONLY": "1", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"},
    ],
)
def test_localhost_uses_the_loopback_interface_alone(environment: dict[str, str]) -> None:
    tree = settings(**environment)
    assert [place.get("address") for place in tree.iter("NetworkInterface")] == ["127.0.0.1"]
    assert tree.findtext(".//AllowMulticast") == "false"
    assert peers(tree) == ["127.0.0.1"]


@pytest.mark.parametrize("environment", [{}, {"ROS_LOCALHOST_ONLY": "0"}])
def test_the_subnet_is_the_default(environment: dict[str, str]) -> None:
    tree = settings(**environment)
    assert not list(tree.iter("NetworkInterface"))
    assert tree.find(".//AllowMulticast") is None
    assert peers(tree) == ["127.0.0.1"]


def test_static_peers_are_asked_too_however_they_are_written() -> None:
    assert peers(settings(ROS_STATIC_PEERS='10.0.0.7;;a"b<c')) == ["127.0.0.1", "10.0.0.7", 'a"b<c']


def test_off_is_found_by_nobody() -> None:
    tree = settings(ROS_AUTOMATIC_DISCOVERY_RANGE="OFF", ROS_STATIC_PEERS="10.0.0.7")
    assert peers(tree) == []
    assert tree.findtext(".//AllowMulticast") == "false"
    assert (tree.findtext(".//Tag") or "").startswith("ros_discovery_off_")


def test_the_system_default_leaves_discovery_to_cyclone() -> None:
    tree = settings(ROS_AUTOMATIC_DISCOVERY_RANGE="SYSTEM_DEFAULT", ROS_STATIC_PEERS="10.0.0.7")
    assert tree.find(".//Discovery") is None


def test_what_the_user_says_to_cyclone_comes_last_and_so_wins() -> None:
    settings(CYCLONEDDS_URI="file:///etc/cyclone.xml")


LO = '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo"/></Interfaces></General>'
LO += "</Domain></CycloneDDS>"


@pytest.mark.parametrize("written", ["{xml}", "file://{file}", "{file}", "<!-- mine, -->,{file}"])
def test_interfaces_that_the_user_names_are_the_only_ones(written: str, tmp_path: Path) -> None:
    (tmp_path / "cyclone.xml").write_text(LO)
    uri = written.format(xml=LO, file=tmp_path / "cyclone.xml")
    tree = settings(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST", CYCLONEDDS_URI=uri)
    assert not list(tree.iter("NetworkInterface"))
    assert tree.findtext(".//AllowMulticast") == "false"


@pytest.mark.parametrize("uri", [f"<!-- {LO} -->", "file:///none.xml", "/dev/zero", "a\0b", ""])
def test_what_names_no_interface_leaves_the_loopback(uri: str) -> None:
    tree = settings(ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST", CYCLONEDDS_URI=uri)
    assert [place.get("address") for place in tree.iter("NetworkInterface")] == ["127.0.0.1"]


def test_a_range_that_cannot_be_is_refused() -> None:
    with pytest.raises(ConfigError, match="ROS_AUTOMATIC_DISCOVERY_RANGE is 'NEAR': set it to"):
        cyclone_settings({"ROS_AUTOMATIC_DISCOVERY_RANGE": "NEAR"})
