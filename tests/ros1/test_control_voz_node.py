"""The node `control_voz`: any recognizer's strings drive the robot, and nothing drives it on."""

from __future__ import annotations

import re
import signal
import time
from pathlib import Path

import pytest
from programs import PATIENCE
from ros1.ros import Client, Program, Ros, eventually

pytestmark = pytest.mark.realtime

COMMANDS = {
    "go forward": (0.1, 0.0),
    "speed up": (0.15, 0.0),
    "turn left": (0.15, 0.1),
    "slow down": (0.1, 0.1),
    "turn right": (0.1, -0.1),
    "rotate left": (0.0, 0.1),
    "rotate right": (0.0, -0.1),
    "go back": (-0.1, 0.0),
    "stop": (0.0, 0.0),
}
"""In this order; the velocities are those of the table in docs/commands.md."""


ROSPY_CONNECT_TIMEOUT = 60.0
"""What rospy gives a connection before it tries again, s."""


def driving(ros: Ros, *arguments: str, topics: tuple[str, ...] = ()) -> tuple[Program, Client]:
    """A node that obeys a client, and that client."""
    node = ros.node("control_voz", "_sound:=none", "_listening:=true", *arguments)
    client = ros.client("/cmd_vel", "/selected_object", *topics)
    connect(client, node)
    eventually(client.velocities)
    return node, client


def connect(client: Client, node: Program, topic: str = "/recognizer/output") -> None:
    """Wait until the node hears the client; what is said before is lost."""
    hello = f"hello from {client.process.pid}"

    def is_heard() -> bool:
        client.say(hello, topic)
        time.sleep(0.1)
        return hello in node.text

    eventually(is_heard, ROSPY_CONNECT_TIMEOUT + PATIENCE)


def test_each_command_does_what_the_readme_says(ros: Ros) -> None:
    _, client = driving(ros)
    for command, velocity in COMMANDS.items():
        client.say(command)
        client.wait_for_velocity(*velocity)
    for command in ("point beer", "point cocacola", "fold arm"):
        client.say(command)
    eventually(lambda: client.of("/selected_object") == [{"data": n} for n in (1, 2, 100)])
    types = {(message["topic"], message["type"]) for message in client.messages}
    assert types == {("/cmd_vel", "geometry_msgs/Twist"), ("/selected_object", "std_msgs/Int16")}


def test_names_can_be_remapped_and_put_into_a_namespace(ros: Ros) -> None:
    node = ros.node(
        "control_voz", "_sound:=none", "_listening:=true", "cmd_vel:=/base/velocity",
        "recognizer/output:=words", env={"ROS_NAMESPACE": "robot1"},
    )  # fmt: skip
    client = ros.client("/base/velocity", "/robot1/selected_object")
    connect(client, node, "/robot1/words")
    client.say("point beer", "/robot1/words")
    eventually(lambda: client.of("/robot1/selected_object"))
    client.say("go forward", "/robot1/words")
    client.wait_for_velocity(0.1, 0, "/base/velocity")


def test_the_beat_is_10_hertz(ros: Ros) -> None:
    driving(ros)
    counting = ros.start("rostopic", "hz", "-w", "20", "/cmd_vel")
    # A computer that is held up has fewer beats in that time, and then again ten in a second.
    eventually(lambda: any(rate == pytest.approx(10, abs=0.1) for rate in rates_of_20(counting)))


def rates_of_20(counting: Program) -> list[float]:
    """What `rostopic hz` told of windows of 20 messages, Hz."""
    told = re.findall(r"average rate: ([0-9.]+)\n.*window: 20\n", counting.text)
    return [float(rate) for rate in told]


def test_replies_are_asked_for_on_robotsound(ros: Ros) -> None:
    _, client = driving(ros, "_listening:=false", "_sound:=ros", topics=("/robotsound",))
    client.say("start speech")
    eventually(lambda: client.of("/robotsound"))
    (message,) = [m for m in client.messages if m["topic"] == "/robotsound"]
    assert (message["type"], message["md5"]) == (
        "sound_play/SoundRequest",
        "d098ce4a040686259137ece23a625167",
    )
    assert message["data"] == {
        "sound": -3,
        "command": 1,
        "volume": 1.0,
        "arg": "bep bep. I am listening you",
        "arg2": "voice_kal_diphone",
    }


def test_sounds_are_asked_for_on_robotsound_too(ros: Ros, tmp_path: Path) -> None:
    (tmp_path / "ding.wav").write_bytes(b"")
    table = f'{{ play = "{tmp_path}/ding.wav" }}, {{ play = "backing-up" }}'
    (tmp_path / "sounds.toml").write_text(f'[commands]\n"greet" = [{table}]\n')
    own = f"_config:={tmp_path}/sounds.toml"
    _, client = driving(ros, "_sound:=ros", own, topics=("/robotsound",))
    client.say("greet")
    eventually(lambda: len(client.of("/robotsound")) == 2)
    asked = [(m["sound"], m["command"], m["arg"]) for m in client.of("/robotsound")]
    assert asked == [(-2, 1, f"{tmp_path}/ding.wav"), (1, 1, "")]


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_s7_a_signal_ends_with_zero_velocity(ros: Ros, number: int) -> None:
    node, client = driving(ros)
    client.say("go forward")
    client.wait_for_velocity(0.1, 0)
    node.process.send_signal(number)
    assert node.wait() == 0
    assert "Traceback" not in node.text
    client.wait_for_velocity(0, 0)


def test_s7_rosnode_kill_ends_with_zero_velocity(ros: Ros) -> None:
    node, client = driving(ros)
    client.say("go forward")
    client.wait_for_velocity(0.1, 0)
    assert ros.call("rosnode", "kill", "/control_voz").returncode == 0
    assert node.wait() == 0
    client.wait_for_velocity(0, 0)


def test_s5_the_robot_stops_when_the_recognizer_is_killed(ros: Ros) -> None:
    node, client = driving(ros)
    watching = ros.client("/cmd_vel")
    client.say("go forward")
    watching.wait_for_velocity(0.1, 0)
    client.kill()
    watching.wait_for_velocity(0, 0)
    node.wait_for("no recognizer publishes on /recognizer/output: the robot stops")
    another = ros.client()
    connect(another, node)
    another.say("go back")
    watching.wait_for_velocity(-0.1, 0)


def test_s5_the_robot_stops_when_the_master_is_killed_and_obeys_the_next_master(ros: Ros) -> None:
    node, client = driving(ros)
    client.say("go forward")
    client.wait_for_velocity(0.1, 0)
    ros.master.kill()
    client.wait_for_velocity(0, 0)
    node.wait_for("does not answer): the robot stops")
    ros.start_master()
    node.wait_for("ROS is there; the robot waits for a command")
    assert client.velocities()[-1] == (0, 0)
    another = ros.client("/cmd_vel")
    connect(another, node)
    another.say("go back")
    another.wait_for_velocity(-0.1, 0)


def test_the_robot_process_may_die_and_come_back(ros: Ros) -> None:
    node, client = driving(ros)
    base = ros.client("/cmd_vel")
    client.say("go forward")
    base.wait_for_velocity(0.1, 0)
    base.kill()
    client.say("go back")
    ros.client("/cmd_vel").wait_for_velocity(-0.1, 0)
    assert "robot stops" not in node.text.split('"go forward"')[-1]
