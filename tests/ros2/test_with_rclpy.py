"""Against the real rclpy on Fast DDS: another implementation, and of another maker."""

from __future__ import annotations

import json
import random
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from math import cos, pi
from typing import Any

import pytest
from programs import Program, wait_until
from recordings import ROOT

from voz.config import Config
from voz.control.steps import Step
from voz.events import Event, Notice, Publish, SelectedObject, Twist, Utterance
from voz.robot.simulation.world import Pose2D, WorldState
from voz.ros2 import Ros2Robot, listen_to_recognizer
from voz.settings import Ros2

pytestmark = pytest.mark.slow

CYCLES = 600
"""A minute of driving, in a fifth of the time."""

TYPES = {
    "/cmd_vel": "geometry_msgs/msg/Twist",
    "/selected_object": "std_msgs/msg/Int16",
    "/recognizer/output": "std_msgs/msg/String",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}

Base = Callable[..., Program]
Line = dict[str, Any]


@contextmanager
def opened(settings: Ros2) -> Iterator[tuple[Ros2Robot, list[str]]]:
    """A robot whose topics are all listened to, and what it says of that."""
    told: list[Notice] = []
    robot = Ros2Robot(settings, told.append)
    robot.open()
    wait_until(lambda: all(writer.get_matched_subscriptions() for writer in robot.writers))
    texts = [warning.text for warning in told]
    try:
        yield robot, texts
    finally:
        robot.close()


def said(text: str) -> Utterance:
    return Utterance(0.0, text, 0.9, True, 0.0, 0.0, "microphone", obeyed=True)


def messages(lines: list[Line], topic: str) -> list[Any]:
    return [line["message"] for line in lines if line.get("topic") == topic]


def twist(linear: float, angular: float) -> Any:
    return {
        "linear": {"x": linear, "y": 0.0, "z": 0.0},
        "angular": {"x": 0.0, "y": 0.0, "z": angular},
    }


def is_twist(linear: float, angular: float = 0.0) -> Callable[[Line], bool]:
    return lambda line: line.get("message") == twist(linear, angular)


def hash_of_tf() -> str:
    """What ROS makes of the definition of a TFMessage: a list of TransformStamped."""
    file = ROOT / ".venv-rclpy/share/geometry_msgs/msg/TransformStamped.json"
    inner = json.loads(file.read_text())["type_description_msg"]
    types = [inner["type_description"], *inner["referenced_type_descriptions"]]
    for field in (field for kind in types for field in kind["fields"]):
        del field["default_value"]
    name = types[0]["type_name"]
    # 145 is a list without a limit, of other messages.
    listed = {"type_id": 145, "capacity": 0, "string_capacity": 0, "nested_type_name": name}
    outer = {
        "type_name": "tf2_msgs/msg/TFMessage",
        "fields": [{"name": "transforms", "type": listed}],
    }
    types.sort(key=lambda kind: str(kind["type_name"]))
    text = json.dumps({"type_description": outer, "referenced_type_descriptions": types})
    return f"RIHS01_{sha256(text.encode()).hexdigest()}"


def subscribed(robot: Ros2Robot, topic: str) -> object:
    (writer,) = [writer for writer in robot.writers if writer.topic.name == f"rt/{topic}"]
    return writer.get_matched_subscriptions()


def drive(robot: Ros2Robot, until: Callable[[], object]) -> None:
    """Send zero velocities until it is true."""
    begun = time.monotonic()

    def send() -> object:
        robot.receive(Twist(time.monotonic() - begun, 0.0, 0.0))
        time.sleep(0.08)
        return until()

    wait_until(send)


def test_rclpy_sees_all_topics_with_its_own_types_and_hashes(base: Base) -> None:
    def complete(line: Line) -> bool:
        graph = line.get("graph", {})
        return all(graph.get(topic, {}).get("writers") for topic in TYPES)

    node = base()
    with opened(Ros2(wait=30)):
        graph = node.wait_for(complete)[-1]["graph"]
    for topic, kind in TYPES.items():
        assert graph[topic]["types"] == [kind]
        assert graph[topic]["writers"] == graph[topic]["own"]
        ((written, type_hash),) = graph[topic]["writers"]
        assert written == kind
        assert type_hash.startswith("RIHS01_")


def test_rclpy_reads_every_message_exactly(base: Base) -> None:
    velocities = [(0.1, 0.0), (-0.15, 0.1), (1 / 3, -1e-300), (0.0, -1.0), (0.5, 1.0)]
    numbers, texts = [1, 2, 100, -32768, 32767], ["go back", "ve a la cocina, señor", ""]
    events: list[Event] = [
        *(Twist(0.0, *velocity) for velocity in velocities),
        *(SelectedObject(0.0, number) for number in numbers),
        *(said(text) for text in texts),
        Twist(1.0, 0.25, 0.0),
    ]
    topics = "cmd_vel", "selected_object", "recognizer/output", "/diagnostics"
    node = base()
    with opened(Ros2(wait=30)) as (robot, told):
        assert told == ["/base listens to /cmd_vel"]
        for event in events:
            robot.receive(event)
        # Each topic keeps its own order, and no other.
        lines: list[Line] = []

        def complete(line: Line) -> bool:
            lines.append(line)
            counts = [len(messages(lines, topic)) for topic in topics]
            return counts == [len(velocities) + 1, len(numbers), len(texts), 2]

        node.wait_for(complete)
    assert messages(lines, "cmd_vel")[:-1] == [twist(*velocity) for velocity in velocities]
    assert [message["data"] for message in messages(lines, "selected_object")] == numbers
    assert [message["data"] for message in messages(lines, "recognizer/output")] == texts
    first, second = messages(lines, "/diagnostics")
    (status,) = second["status"]
    assert 0 <= second["header"]["stamp"]["sec"] - first["header"]["stamp"]["sec"] <= 30
    assert (status["level"], status["name"]) == (0, "voz: voice control")
    assert status["message"] == "robot drives forward at 0.25 m/s"
    assert {"key": "listeners", "value": "/base"} in status["values"]


def test_rclpy_reads_values_on_topics_of_the_users_own(base: Base) -> None:
    values = {"lamp": True, "count": -70000, "way": 1 / 3, "bring": "knife"}
    publishing = {topic: Step(publish=value, topic=topic) for topic, value in values.items()}
    graph: Line = {}
    lines: list[Line] = []

    def complete(line: Line) -> bool:
        graph.update(line.get("graph", {}))
        lines.append(line)
        known = all(graph.get(f"/{topic}", {}).get("writers") for topic in values)
        return known and all(messages(lines, topic) for topic in values)

    node = base(values=True)
    robot = Ros2Robot(Ros2(wait=30), table=Config(commands=publishing).table)
    robot.open()
    drive(robot, until=lambda: all(subscribed(robot, topic) for topic in values))
    for topic, value in values.items():
        robot.receive(Publish(0, topic, value))
    node.wait_for(complete)
    robot.close()
    for topic, value in values.items():
        assert messages(lines, topic) == [{"data": value}]
        assert graph[f"/{topic}"]["writers"] == graph[f"/{topic}"]["own"]


def test_rclpy_reads_where_a_simulated_robot_is(base: Base) -> None:
    graph: Line = {}
    places: list[Any] = []

    def complete(line: Line) -> bool:
        graph.update(line.get("graph", {}))
        places.extend(messages([line], "odom"))
        known = all(graph.get(topic, {}).get("writers") for topic in ("/odom", "/tf"))
        return known and bool(places)

    node = base()
    robot = Ros2Robot(Ros2(wait=30))
    robot.where = lambda t: WorldState(t, Pose2D(1 / 3, -0.5, pi), 0.1, -0.2)
    robot.open()
    drive(robot, until=lambda: subscribed(robot, "odom"))
    robot.receive(Twist(100.0, 0.0, 0.0))
    node.wait_for(complete)
    robot.close()
    message = places[0]
    assert graph["/odom"]["writers"] == graph["/odom"]["own"]
    # There are no wheels of tf2_msgs: rclpy cannot read it, but tell what is published.
    assert graph["/tf"]["writers"] == [["tf2_msgs/msg/TFMessage", hash_of_tf()]]
    assert (message["header"]["frame_id"], message["child_frame_id"]) == ("odom", "base_link")
    assert message["pose"]["pose"]["position"] == {"x": 1 / 3, "y": -0.5, "z": 0.0}
    turned = message["pose"]["pose"]["orientation"]
    assert turned == {"x": 0.0, "y": 0.0, "z": 1.0, "w": cos(pi / 2)}
    assert message["twist"]["twist"] == twist(0.1, -0.2)
    assert message["pose"]["covariance"] == message["twist"]["covariance"] == [0.0] * 36


def test_nothing_is_lost_in_600_cycles(base: Base) -> None:
    chance = random.Random(1)
    sent = [(chance.uniform(-0.5, 0.5), chance.uniform(-1, 1)) for _ in range(CYCLES)]
    node = base()
    with opened(Ros2(wait=30)) as (robot, _):
        for cycle, velocity in enumerate(sent):
            robot.receive(Twist(cycle / 10, *velocity))
            time.sleep(0.02)
        lines = node.wait_for(is_twist(*sent[-1]))
    assert messages(lines, "cmd_vel") == [twist(*velocity) for velocity in sent]


def test_newer_bases_get_a_twist_with_its_time(base: Base) -> None:
    node = base(stamped=True)
    with opened(Ros2(wait=30, stamped=True)) as (robot, _):
        before = time.time()
        robot.receive(Twist(0.0, 0.1, -0.2))
        (message,) = messages(node.wait_for(lambda line: line.get("topic") == "cmd_vel"), "cmd_vel")
        after = time.time()
    assert message["twist"] == twist(0.1, -0.2)
    assert message["header"]["frame_id"] == "base_link"
    stamp = message["header"]["stamp"]
    assert before - 1e-3 <= stamp["sec"] + stamp["nanosec"] / 1e9 <= after + 1e-3


def test_a_namespace_is_that_of_the_node(base: Base) -> None:
    node = base(namespace="/robot1")
    with opened(Ros2(wait=30, namespace="robot1")) as (robot, told):
        assert told == ["/robot1/base listens to /robot1/cmd_vel"]
        robot.receive(Twist(0.0, 0.1, 0.0))
        node.wait_for(is_twist(0.1))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_base_that_is_ended_or_killed_is_lost_and_its_successor_is_not(
    number: int, base: Base
) -> None:
    first = base()
    with opened(Ros2(wait=30)) as (robot, _):
        first.end(number)
        drive(robot, until=robot.lost)
        assert robot.lost() == "nobody listens to /cmd_vel" or number == signal.SIGKILL
        second = base()
        drive(robot, until=lambda: robot.lost() is None)
        robot.receive(Twist(100.0, 0.1, 0.0))
        second.wait_for(is_twist(0.1))


def test_a_base_finds_a_voz_that_starts_again(base: Base) -> None:
    node = base()
    for velocity in (0.1, 0.2):
        with opened(Ros2(wait=30)) as (robot, _):
            robot.receive(Twist(0.0, velocity, 0.0))
            node.wait_for(is_twist(velocity))


def test_what_an_rclpy_node_recognizes_is_heard(base: Base) -> None:
    node, heard = base(), list[str]()
    with listen_to_recognizer(Ros2(), heard.append, heard.append):

        def arrived() -> bool:
            node.say("go forward")
            time.sleep(0.1)
            return bool(heard)

        wait_until(arrived)
        node.say("point cocacola")
        wait_until(lambda: heard[-1] == "point cocacola")
    assert set(heard) == {"go forward", "point cocacola"}
