"""What others drive by is cancelled: asked of the real rclpy, and of ROS 2 on Cyclone."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from cyclonedds.idl import IdlStruct
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from programs import Program, wait_until
from ros2.conftest import ORDINARY, RCLPY

from voz.events import Notice, Partial, Twist, Utterance
from voz.ros2 import Ros2Robot
from voz.ros2.message_types import CycloneCancelAllGoals
from voz.ros2.node import Ros2Node
from voz.settings import Ros2

pytestmark = pytest.mark.usefixtures("domain")

SETTINGS = Ros2(wait=0, cancel=("navigate_to_pose",))
SERVICE = "navigate_to_pose/_action/cancel_goal"
ALL = {"goal": [0] * 16, "stamp": [0, 0]}

SERVERS = [(Path(sys.executable), "cyclone_server.py")]
if ORDINARY:  # the wheels of rclpy are for this processor alone
    SERVERS.append((RCLPY, "cancel_server.py"))


def heard(text: str, obeyed: bool = True) -> Utterance:
    return Utterance(0.0, text, 0.9, True, 0.0, 0.0, "microphone", obeyed=obeyed)


@pytest.mark.parametrize("server", SERVERS, ids=lambda server: server[1])
def test_either_ros_2_is_asked_to_cancel_all_goals(
    server: tuple[Path, str], programs: Callable[..., Program]
) -> None:
    asked = programs(*server, service=SERVICE)
    asked.wait_for(lambda line: line.get("ready"))
    robot = Ros2Robot(SETTINGS)
    robot.open()
    wait_for_servers(robot)
    for text in ("stop", "stop speech"):
        robot.receive(heard(text))
        assert asked.wait_for(lambda line: "goal" in line) == [ALL]
    robot.close()
    assert asked.wait_for(lambda line: "goal" in line) == [ALL]


@pytest.mark.slow
def test_a_server_of_another_kind_may_take_the_place_of_one(
    programs: Callable[..., Program],
) -> None:
    robot = Ros2Robot(SETTINGS)
    robot.open()
    for server in SERVERS:
        asked = programs(*server, service=SERVICE)
        asked.wait_for(lambda line: line.get("ready"))

        def cancels(asked: Program = asked) -> object:  # not by what the one before understood
            robot.receive(Twist(0.0, 0.0, 0.0))
            robot.receive(heard("stop"))
            return not asked.is_silent

        wait_until(cancels)
        assert asked.wait_for(lambda line: "goal" in line) == [ALL]
        asked.end(15)
    robot.close()


def test_only_what_stops_the_robot_cancels() -> None:
    asked = serve(SETTINGS)
    robot = Ros2Robot(SETTINGS)
    robot.open()
    wait_for_servers(robot)
    for event in (
        heard("go forward"),
        heard("stop", obeyed=False),
        Partial(0.0, "stop", 0.5),
        Twist(0.0, 0.0, 0.0),
        Notice(0.0, "no loudspeaker"),
        Notice(0.0, "listening again", good=True),
    ):
        robot.receive(event)
    assert requests(asked) == []
    robot.receive(Notice(0.0, "the microphone is gone: the robot stops", stops=True))
    assert len(requests(asked)) == 1
    robot.close()
    assert len(requests(asked)) == 1


def test_names_stand_in_the_namespace_and_the_list_may_be_empty() -> None:
    settings = Ros2(wait=0, namespace="robot1", cancel=("navigate_to_pose", "/dock"))
    there = [serve(settings, name) for name in settings.cancel]
    assert there[0].topic.name == "rq/robot1/navigate_to_pose/_action/cancel_goalRequest"
    robot = Ros2Robot(settings)
    robot.open()
    wait_for_servers(robot, 2)
    robot.receive(heard("stop"))
    assert [len(requests(one)) for one in there] == [1, 1]
    robot.close()
    assert [len(requests(one)) for one in there] == [1, 1]
    without = Ros2Robot(Ros2(wait=0, namespace="robot1", cancel=()))
    without.open()
    without.receive(heard("stop"))
    without.close()
    assert [len(requests(one)) for one in there] == [0, 0]


def serve(settings: Ros2, action: str = "navigate_to_pose") -> DataReader[Any]:
    """Read what is asked of an action's server on Cyclone."""
    node = Ros2Node(settings)
    name = node.request_topic(f"{action}/_action/cancel_goal")
    topic = Topic(node.participant, name, CycloneCancelAllGoals)
    return DataReader(node.participant, topic, node.qos(CycloneCancelAllGoals))


def requests(reader: DataReader[Any]) -> list[Any]:
    return [one for one in reader.take(100) if isinstance(one, IdlStruct)]


def wait_for_servers(robot: Ros2Robot, number: int = 1) -> None:
    """Let the robot find so many servers."""

    def found() -> bool:
        robot.receive(Twist(0.0, 0.0, 0.0))
        ready = [writer for writer in robot.writers if writer.topic.name.startswith("rq/")]
        return len(ready) == number and all(w.get_matched_subscriptions() for w in ready)

    wait_until(found)
