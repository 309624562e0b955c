"""A robot on ROS 1 for whoever hands it events; the nodes are tested in `tests/ros1`."""

from __future__ import annotations

import struct
import sys

import pytest
from recordings import ROOT
from ros1.ros import Program, Ros, eventually

PROGRAM = """
import sys, time
from voz.config import Config
from voz.settings import Ros1
from voz.control.steps import Step
from voz.errors import RobotError
from voz.events import *
from voz.ros1.robot import Ros1Robot

used = Config(
    commands={
        "light": Step(publish=True, topic="lamp"),
        "count": Step(publish=1, topic="count"),
        "go": Step(publish=0.5, topic="way"),
        "knife": Step(publish="knife", topic="bring"),
    }
)
settings = Ros1(node="own", selected_object="arm", cancel=("move_base", "/dock"))
arguments = ["cmd_vel:=/base"]
told = lambda notice: print(notice.text)
robot = Ros1Robot(settings, arguments=arguments, table=used.table, warn=told)
try:
    robot.open()
except RobotError as error:
    sys.exit(str(error))
events = {
    "forward": Twist(0, 0.1, 0.05),
    "beer": SelectedObject(0, 1),
    "heard": Utterance(0, "go back", 0.9, True, 0, 1, "text", obeyed=True),
    "ignored": Utterance(0, "go on", 0.9, True, 0, 1, "text", obeyed=False),
    "lamp": Publish(0, "lamp", True),
    "count": Publish(0, "count", -70000),
    "way": Publish(0, "way", 0.5),
    "bring": Publish(0, "bring", "knife"),
    "asleep": Attention(0, False),
    "stop": Utterance(0, "stop", 0.9, True, 0, 1, "text", obeyed=True),
    "lost": Notice(0, "the microphone is gone: the robot stops", stops=True),
    "refused": Utterance(0, "go home", 0.2, False, 0, 1, "text"),
}
for line in sys.stdin:
    if line == "place\\n":
        print("place", robot.place(0), flush=True)
        continue
    robot.receive(events[line.strip()])
    print(robot.lost())
robot.close()
"""


def robot(ros: Ros) -> Program:
    return ros.start(str(ROOT / "ros" / "python"), "-c", PROGRAM)


@pytest.mark.slow
def test_it_publishes_what_is_obeyed_and_zero_velocity_last(ros: Ros) -> None:
    client = ros.client("/base", "/arm", "/recognizer/output")
    driven = robot(ros)

    def arrives() -> bool:  # each topic finds its listener by itself, and in its own time
        for event in ("beer", "refused", "ignored", "heard", "forward"):
            driven.type(event)
        heard = (client.velocities("/base"), client.of("/arm"), client.of("/recognizer/output"))
        return all(heard)

    eventually(arrives)
    driven.process.stdin.close()
    assert driven.wait() == 0
    client.wait_for_velocity(0, 0, "/base")
    assert set(client.velocities("/base")) == {(0.1, 0.05), (0, 0)}
    assert all(message == {"data": 1} for message in client.of("/arm"))
    assert all(message == {"data": "go back"} for message in client.of("/recognizer/output"))


@pytest.mark.slow
def test_what_others_drive_by_is_cancelled_where_the_robot_stops(ros: Ros) -> None:
    client = ros.client("/move_base/cancel", "/dock/cancel")
    driven = robot(ros)

    def asked() -> list[int]:
        return [len(client.of(topic)) for topic in ("/move_base/cancel", "/dock/cancel")]

    def arrives() -> bool:  # what was sent before they found each other is lost
        driven.type("stop")
        return all(asked())

    eventually(arrives)
    assert client.messages[0]["type"] == "actionlib_msgs/GoalID"
    all_goals = {"stamp": {"sec": 0, "nsec": 0}, "id": ""}
    assert all(message["data"] == all_goals for message in client.messages)

    def more_than(before: list[int]) -> bool:
        return all(now > then for now, then in zip(asked(), before, strict=True))

    before = asked()
    driven.type("lost")
    eventually(lambda: more_than(before))
    before = asked()
    driven.process.stdin.close()
    assert driven.wait() == 0
    eventually(lambda: more_than(before))


def test_it_says_that_the_master_is_lost_and_lets_nothing_move(ros: Ros) -> None:
    client = ros.client("/base")
    driven = robot(ros)

    def arrives() -> bool:
        driven.type("forward")
        return bool(client.velocities("/base"))

    eventually(arrives)
    assert "None\n" in driven.text
    ros.master.kill()

    def is_lost() -> bool:
        driven.type("forward")
        return "does not answer" in driven.text

    eventually(is_lost)
    driven.type("forward")
    client.wait_for_velocity(0, 0, "/base")


@pytest.mark.realtime
def test_voz_run_drives_it_and_tells_where_the_simulated_robot_is(ros: Ros) -> None:
    client = ros.client("/robot1/cmd_vel", "/robot1/odom", "/tf", "/robot1/selected_object")
    run = ros.start(
        *(str(ROOT / "ros" / "python"), "-m", "voz", "run", "--robot", "simulator,ros1"),
        *("--text", "-", "--listening", "--no-sound"),
        env={"ROS_NAMESPACE": "robot1"},
    )

    def drives() -> bool:
        run.type("go forward")
        return (0.1, 0.0) in client.velocities("/robot1/cmd_vel")

    eventually(drives)
    run.type("point cocacola")
    eventually(lambda: client.of("/robot1/selected_object") == [{"data": 2}])
    eventually(lambda: client.of("/robot1/odom")[-1]["pose"]["pose"]["position"]["x"] > 0.72)
    assert client.of("/tf")
    run.process.terminate()
    assert run.wait() == 143
    client.wait_for_velocity(0, 0, "/robot1/cmd_vel")


def test_voz_run_without_a_master_says_so_in_one_line(ros: Ros) -> None:
    ros.master.kill()
    command = [str(ROOT / "ros" / "python"), "-m", "voz", "run", "--robot", "ros1", "--text", "-"]
    done = ros.call(*command, input="stop\n")
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("voz: there is no ROS master at ")


@pytest.mark.slow
def test_it_publishes_values_of_the_users_own_topics(ros: Ros) -> None:
    topics = ("/lamp", "/count", "/way", "/bring", "/recognizer/awake")
    client = ros.client(*topics)
    driven = robot(ros)

    def arrives() -> bool:
        for topic in topics:
            driven.type("asleep" if topic.endswith("awake") else topic.removeprefix("/"))
        return all(client.of(topic) for topic in topics)

    eventually(arrives)
    driven.process.stdin.close()
    assert driven.wait() == 0
    found = [client.of(topic)[0] for topic in topics]
    assert [each["data"] for each in found] == [True, -70000, 0.5, "knife", False]


def odometry(x: float) -> bytes:
    """A `nav_msgs/Odometry` as it is sent."""
    frames = struct.pack("<IIII4sI4s", 0, 0, 0, 4, b"odom", 4, b"base")
    return frames + struct.pack("<85d", x, *(0.0,) * 5, 1.0, *(0.0,) * 78)


@pytest.mark.slow
def test_odometry_that_cannot_be_read_is_dropped_and_the_next_is_taken(ros: Ros) -> None:
    driven = robot(ros)
    file, kind = str(ROOT / "tests" / "ros1" / "raw_publisher.py"), "nav_msgs/Odometry"
    base = ros.start(sys.executable, file, "/odom", kind, "cd5e73d190d741a2f92e81eda573aca7")
    base.wait_for("subscribed")
    whole = odometry(-1)

    def tells(x: int) -> bool:
        base.type(odometry(x).hex())
        driven.type("place")
        return f"place ({x}.0, 0.0, 0.0)" in driven.text

    malformed = (b"", whole[:15], whole[:100], b"\xff" * 700, whole.replace(b"odom", b"\xf6dom"))
    for x, data in enumerate(malformed):
        base.type(data.hex())
        eventually(lambda x=x: tells(x))  # type: ignore[misc]


@pytest.mark.slow
def test_it_tells_who_else_sends_velocities(ros: Ros) -> None:
    driven = robot(ros)

    def tells(text: str) -> bool:
        driven.type("stop")
        driven.type("forward")
        return text in driven.text

    eventually(lambda: tells("None\n"))
    assert "sends velocities" not in driven.text
    other = ros.start("rostopic", "pub", "-r", "1", "/base", "geometry_msgs/Twist", "{}")
    eventually(lambda: tells(" sends velocities on /base too: let only one program send"))
    other.kill()  # the master still names it
    eventually(lambda: tells(" left /base"))
    assert driven.text.count("sends velocities") == 1


@pytest.mark.slow
def test_it_knows_where_the_base_says_that_it_is(ros: Ros) -> None:
    driven = robot(ros)
    driven.type("place")
    driven.wait_for("place None")
    ros.node("simulator")

    def tells() -> bool:
        driven.type("place")
        return "place (0.7, 0.6, 0.0)" in driven.text

    eventually(tells)
