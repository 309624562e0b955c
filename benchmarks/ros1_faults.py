"""How even the beat of `cmd_vel` is on ROS 1, and how soon the robot stops when a part is killed.

Run `python benchmarks/ros1_faults.py [--times N]` when `make test` has installed ROS 1. A master,
the node `control_voz` and clients that share no code with rospy are started for each measurement.
The time runs from the kill to the first zero velocity that arrives at a client.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from machine import machine

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from ros1.ros import Client, Program, Ros, eventually, running_ros

BEAT_SECONDS = 60


def driving(ros: Ros) -> tuple[Program, Client, Client]:
    """A robot that drives: the node, who gave the command, and who receives `cmd_vel`."""
    node = ros.node("control_voz", "_sound:=none", "_listening:=true")
    speaking, watching = ros.client(), ros.client("/cmd_vel")

    def drives() -> bool:
        speaking.say("go forward")
        time.sleep(0.1)
        return (0.1, 0.0) in watching.velocities()

    eventually(drives)
    return node, speaking, watching


def time_to_stop(fault: Callable[[Ros, Program, Client], None]) -> float:
    """Let something go wrong; gives the time until the robot is told to stand still, s."""
    with tempfile.TemporaryDirectory() as folder, running_ros(Path(folder)) as ros:
        node, speaking, watching = driving(ros)
        begun = time.time()
        fault(ros, node, speaking)
        watching.wait_for_velocity(0, 0)
        messages = [m for m in watching.messages if m["at"] >= begun]
        zero = next(m for m in messages if m["data"]["linear"]["x"] == 0)
        return float(zero["at"] - begun)


def beat() -> str:
    """The rate of `cmd_vel` and its deviation, as a client sees them."""
    with tempfile.TemporaryDirectory() as folder, running_ros(Path(folder)) as ros:
        _, _, watching = driving(ros)
        before = len(watching.messages)
        time.sleep(BEAT_SECONDS)
        steps = np.diff([message["at"] for message in watching.messages[before:]])
        return f"{1 / steps.mean():.3f} Hz, deviation {1000 * steps.std():.1f} ms"


FAULTS: dict[str, Callable[[Ros, Program, Client], None]] = {
    "kill -9 of the recognizer": lambda ros, node, speaking: speaking.kill(),
    "kill -9 of the master": lambda ros, node, speaking: ros.master.kill(),
    "SIGTERM to control_voz": lambda ros, node, speaking: node.process.terminate(),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=10)
    times = parser.parse_args().times
    print(f"{machine()}\n\n`cmd_vel` for {BEAT_SECONDS} s: {beat()}\n")
    print(f"| {times} times each | median | longest |\n|---|---|---|")
    for name, fault in FAULTS.items():
        stops = [time_to_stop(fault) for _ in range(times)]
        print(f"| {name} | {np.median(stops):.2f} s | {max(stops):.2f} s |", flush=True)


if __name__ == "__main__":
    main()
