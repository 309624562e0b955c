"""Both launch files, spoken to through a microphone, with the robot at the other end."""

from __future__ import annotations

import signal
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from live_robot import speak
from recordings import GO_BACK, ROOT
from ros1.ros import Client, Program, Ros, eventually

COMMANDS = GO_BACK.parent
START, FORWARD, POINT = (
    COMMANDS / f"festival_slt__{name}.flac" for name in ("start_speech", "go_forward", "point_beer")
)


def hearing(
    ros: Ros, file: str, *arguments: str, topic: str = "/cmd_vel"
) -> tuple[Program, Client]:
    """A launch file that drives, and a client that sees everything."""
    launch = ros.launch(file, *arguments)
    client = ros.client(
        "/cmd_vel", "/recognizer/output", "/recognizer/trouble", "/selected_object", "/odom", "/tf"
    )
    eventually(lambda: hears(client, launch) or launch.process.poll() is not None)
    assert launch.process.poll() is None, launch.text
    return launch, client


def hears(client: Client, control: Program) -> bool:
    """Whether the control runs, and has found the recognizer if it did not at once."""
    lost, found = (control.text.count(t) for t in ("the robot stops", "listening again"))
    return bool(client.velocities()) and lost == found


def speak_until(ros: Ros, happens: Callable[[], object], *recordings: Path) -> None:
    """Speak into the microphone again and again: a busy machine loses some of the sound."""

    def tried() -> object:
        for recording in recordings:
            speak(ros.environment, recording)
        return happens()

    eventually(tried)


@pytest.mark.parametrize("file", ["comandos_voz.launch", "control_voz.launch"])
def test_roslaunch_calls_no_argument_required_that_is_not(file: str, ros: Ros) -> None:
    listed = ros.call("roslaunch", "--ros-args", "voz", file).stdout
    assert "Required" not in listed
    names = {
        arg.get("name") for arg in ElementTree.parse(ROOT / "ros" / "launch" / file).iter("arg")
    }
    assert {line.split()[0] for line in listed.splitlines()[1:]} == names


@pytest.mark.slow
def test_comandos_voz_is_the_recognizer_alone(ros_with_sound: Ros) -> None:
    ros = ros_with_sound
    ros.launch("comandos_voz.launch", "device:=pulse")
    client = ros.client("/recognizer/output", "/recognizer/trouble")
    eventually(lambda: {"data": ""} in client.of("/recognizer/trouble"))
    speak(ros.environment, GO_BACK)
    eventually(lambda: client.of("/recognizer/output") == [{"data": "go back"}])
    nodes = ros.call("rosnode", "list").stdout.split()
    assert {node for node in nodes if "client" not in node} == {"/recognizer"}


@pytest.mark.slow
@pytest.mark.parametrize("one_process", ["false", "true"])
def test_control_voz_drives_the_simulator(ros_with_sound: Ros, one_process: str) -> None:
    ros = ros_with_sound
    launch, client = hearing(
        ros, "control_voz.launch", "robot:=simulator", f"one_process:={one_process}"
    )

    def odometry() -> Any:
        return client.of("/odom")[-1]

    # It may not be heard while the robot says its reply.
    speak_until(ros, lambda: client.of("/selected_object"), START, POINT)
    assert client.of("/selected_object")[0] == {"data": 1}
    # Where a busy machine loses sound the robot stops, and goes on only when it is told again.
    speak_until(ros, lambda: odometry()["twist"]["twist"]["linear"]["x"] > 0.09, FORWARD)
    assert (0.1, 0) in client.velocities()
    at, transform = odometry(), client.of("/tf")[-1]["transforms"][0]
    assert at["pose"]["pose"]["position"]["x"] > 0.7
    frames = (transform["header"]["frame_id"], transform["child_frame_id"])
    assert frames == (at["header"]["frame_id"], at["child_frame_id"])
    assert frames == ("odom", "base_link")
    launch.process.send_signal(signal.SIGINT)
    assert launch.wait() == 0
    client.wait_for_velocity(0, 0)
    assert "Traceback" not in launch.text


@pytest.mark.slow
def test_the_recognizer_is_killed_and_the_robot_stops(ros_with_sound: Ros) -> None:
    ros = ros_with_sound
    recognizer = ros.node("recognizer")
    control = ros.node("control_voz", "_listening:=true", "_sound:=none")
    client = ros.client("/cmd_vel", "/recognizer/trouble")
    eventually(lambda: hears(client, control))
    speak_until(ros, lambda: client.velocities()[-1] == (0.1, 0), FORWARD)
    recognizer.process.send_signal(signal.SIGSTOP)  # hangs, but its connections are there
    client.wait_for_velocity(0, 0)
    control.wait_for("the recognizer does not answer: the robot stops")
    recognizer.process.send_signal(signal.SIGCONT)
    control.wait_for("waits for a command")
    speak_until(ros, lambda: client.velocities()[-1] == (0.1, 0), FORWARD)
    recognizer.kill()
    client.wait_for_velocity(0, 0)
    control.wait_for("no recognizer publishes")


@pytest.mark.slow
def test_each_command_is_logged_once_by_the_node_that_obeys_it(ros_with_sound: Ros) -> None:
    ros = ros_with_sound
    recognizer = ros.node("recognizer")
    control = ros.node("control_voz", "_listening:=true", "_sound:=none")
    client = ros.client("/cmd_vel", "/recognizer/output", "/selected_object")
    eventually(lambda: hears(client, control))
    speak_until(ros, lambda: client.of("/selected_object"), POINT)
    published = {"data": "point beer"}
    eventually(
        lambda: control.text.count("point beer") == client.of("/recognizer/output").count(published)
    )
    assert 'heard "point beer"' in control.text
    assert "point beer" not in recognizer.text


@pytest.mark.slow
def test_the_simulator_stops_by_itself_when_whoever_drives_it_is_killed(ros: Ros) -> None:
    ros.node("simulator")
    driver, watching = ros.client(), ros.client("/odom")
    velocity = {"linear": {"x": 0.2, "y": 0, "z": 0}, "angular": {"x": 0, "y": 0, "z": 0}}

    def moves() -> bool:
        driver.publish("/cmd_vel", data=velocity, **TWIST)
        return bool(speeds(watching)) and speeds(watching)[-1] > 0.1

    eventually(moves)
    driver.kill()
    eventually(lambda: speeds(watching)[-1] == 0)


TWIST = {
    "type": "geometry_msgs/Twist",
    "definition": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"
    + "=" * 80
    + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n",
}


def speeds(client: Client) -> list[float]:
    return [data["twist"]["twist"]["linear"]["x"] for data in client.of("/odom")]


def test_the_package_names_the_version_of_voz() -> None:
    package = ElementTree.parse(ROOT / "ros" / "package.xml").getroot()
    assert package.findtext("name") == "voz"
    version = package.findtext("version")
    assert f'version = "{version}"' in (ROOT / "pyproject.toml").read_text()
