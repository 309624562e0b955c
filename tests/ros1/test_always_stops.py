"""What only rospy and a real master show: `control_voz` and its watchdog always stop the robot."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import pytest
from programs import PATIENCE
from ros1.ros import Client, Program, Ros, eventually
from ros1.test_control_voz_node import connect

pytestmark = pytest.mark.realtime

DRIVING = ("_sound:=none", "_listening:=true")


def driven(ros: Ros, node: Program) -> Client:
    """A client that lets a node drive."""
    client = ros.client("/cmd_vel")
    connect(client, node)
    client.say("go forward")
    client.wait_for_velocity(0.1, 0)
    return client


class Unread(Program):
    """A program whose output nobody reads, once it is driven."""

    def stop_reading(self) -> None:
        self.reads = False

    def _read(self) -> None:
        self.reads = True
        for line in self.process.stdout:
            self.lines.append(line)
            while not self.reads and self.process.poll() is None:
                time.sleep(0.05)


def test_neither_an_output_that_nobody_reads_nor_a_flood_delays_stop_or_the_end(ros: Ros) -> None:
    node = ros.node("control_voz", *DRIVING, kind=Unread)
    client = driven(ros, node)
    node.stop_reading()
    for _ in range(5):
        client.say("x" * 200_000)
        client.say("y " * 100)
    client.say("go back")
    client.wait_for_velocity(-0.1, 0)
    client.type('{"topic": "/recognizer/output", "flood": 5000}')
    time.sleep(1)
    client.say("stop")
    client.wait_for_velocity(0, 0)
    node.process.terminate()
    assert node.process.wait(PATIENCE) == 0
    assert client.velocities()[-1] == (0, 0)
    eventually(lambda: "watchdog" not in ros.call("rosnode", "list").stdout)


def test_after_a_pause_of_the_process_the_motion_is_over(ros: Ros) -> None:
    node = ros.node("control_voz", *DRIVING)
    client = driven(ros, node)
    os.kill(node.process.pid, signal.SIGSTOP)
    client.wait_for_velocity(0, 0)  # the watchdog's
    time.sleep(1)
    os.kill(node.process.pid, signal.SIGCONT)
    node.wait_for("control loop stalled for")
    since = len(client.messages)
    eventually(lambda: len(client.messages) > since + 10)
    assert set(client.velocities()[-5:]) == {(0, 0)}
    client.say("go back")
    client.wait_for_velocity(-0.1, 0)


def test_nodes_moved_by_their_arguments_have_each_a_watchdog_that_goes_with_them(
    ros: Ros, tmp_path: Path
) -> None:
    first = ros.node(
        "control_voz", *DRIVING, "__ns:=/r1", "cmd_vel:=~velocity", f"__log:={tmp_path}/own.log",
        f"__master:=http://127.0.0.1:{ros.port}", env={"ROS_MASTER_URI": "http://127.0.0.1:1"},
    )  # fmt: skip
    second = ros.node(
        "control_voz", *DRIVING, "__ns:=r2", "__name:=mine", "cmd_vel:=/base/velocity"
    )
    driven = [
        (first, "/r1/recognizer/output", "/r1/control_voz/velocity"),
        (second, "/r2/recognizer/output", "/base/velocity"),
    ]
    client = ros.client(*(velocity for _, _, velocity in driven))
    for node, words, velocity in driven:
        connect(client, node, words)
        client.say("go forward", words)
        client.wait_for_velocity(0.1, 0, velocity)
        assert "sends velocities" not in node.text  # its watchdog does not count
    names = set(ros.call("rosnode", "list").stdout.split())
    assert {"/r1/control_voz_watchdog", "/r2/mine_watchdog"} <= names
    assert {path.name for path in tmp_path.glob("*.log")} >= {"own.log", "own_watchdog.log"}
    for node, _, velocity in driven:
        node.kill()
        client.wait_for_velocity(0, 0, velocity)


def test_a_watchdog_that_is_killed_stops_the_robot_and_is_there_again(ros: Ros) -> None:
    node = ros.node("control_voz", *DRIVING)
    client = driven(ros, node)
    (first,) = children(node)
    os.kill(first, signal.SIGKILL)
    client.wait_for_velocity(0, 0)
    node.wait_for("watchdog is there; the robot waits for a command")
    assert children(node) != [first]
    client.say("go back")
    client.wait_for_velocity(-0.1, 0)
    rest = children(node)
    node.kill()
    for process in rest:  # systemd does so at once, and kills them 10 s later
        os.kill(process, signal.SIGTERM)
    client.wait_for_velocity(0, 0)


def children(node: Program) -> list[int]:
    """The processes that a node has started, and that still run."""
    tasks = Path(f"/proc/{node.process.pid}/task").iterdir()
    return [int(child) for task in tasks for child in (task / "children").read_text().split()]
