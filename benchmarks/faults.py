"""How soon the robot is told to stand when something breaks: microphone, page, robot, ROS 1.

Run `python benchmarks/faults.py [--times N] [--only WORD]`; ROS 1 is that of `make test`. The time
runs from a real fault to the first zero velocity outside: among the events of `voz run`, at the
robot that `kill -9` leaves alone, or at a client of ROS 1 that shares no code with rospy.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from subprocess import Popen

import numpy as np
from machine import machine

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from live_robot import LiveRobot, broken_recognizer, live_robot, moves, rests
from operator_page import Page, opened, page_robot
from promises.real_run import watched
from pulseaudio import sound_server
from recordings import ROOT
from ros1.ros import Client, Program, Ros, eventually, running_ros


@contextmanager
def driving(*arguments: str, before: str = "") -> Iterator[tuple[LiveRobot, Popen[bytes]]]:
    paths = {"PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests" / "promises")])}
    with (
        sound_server() as (environment, server),
        live_robot(environment | paths, "--listening", *arguments, before=before) as robot,
    ):
        robot.type("go forward")
        robot.wait_for(moves)
        time.sleep(1)  # the room is heard
        yield robot, server


def until_zero(robot: LiveRobot, cause: Callable[[], object]) -> float:
    since, begun = len(robot.arrived), time.monotonic()
    cause()
    return robot.wait_for(rests, since).when - begun


def server(number: signal.Signals) -> float:
    with driving() as (robot, server):
        return until_zero(robot, lambda: server.send_signal(number))


def recognizer(fault: str) -> float:
    file = Path("broken")
    with driving(before=broken_recognizer(file, fault)) as (robot, _):
        return until_zero(robot, file.touch)


def ended() -> float:
    with driving() as (robot, _):
        begun = time.monotonic()
        robot.end(signal.SIGTERM)
        assert rests(robot.arrived[-1].event), "zero velocity was not the last event"
        return robot.arrived[-1].when - begun


def page(lose: Callable[[Page], object]) -> float:
    with page_robot({**os.environ}, "--listening") as robot, opened(robot) as page:
        page.start_driving()
        robot.command("go forward", page=page.welcome["secret"]).raise_for_status()
        robot.robot.wait_for(moves)
        return until_zero(robot.robot, lambda: lose(page))


def own_robot(fault: str) -> float:
    """Let a robot of a user's fail, beside another that is to be stopped."""
    with driving("--robot", "own_robots:Faulty,console") as (robot, _):
        return until_zero(robot, lambda: Path("fault").write_text(fault))


def killed() -> float:
    with sound_server() as (environment, _), watched(Path.cwd(), environment) as run:
        run.drive()
        begun = time.monotonic()
        run.process.kill()
        run.wait_for("0.0")
        return time.monotonic() - begun


def ros1(fault: Callable[[Ros, Program, Client], object]) -> float:
    with running_ros(Path.cwd()) as ros:
        node = ros.node("control_voz", "_sound:=none", "_listening:=true")
        speaking, watching = ros.client(), ros.client("/cmd_vel")

        def drives() -> bool:
            speaking.say("go forward")
            time.sleep(0.1)
            return (0.1, 0.0) in watching.velocities()

        eventually(drives)
        begun = time.time()
        fault(ros, node, speaking)
        watching.wait_for_velocity(0, 0)
        zeros = [each["at"] for each in watching.messages if not each["data"]["linear"]["x"]]
        return float(min(at for at in zeros if at >= begun) - begun)


FAULTS: dict[str, Callable[[], float]] = {
    "microphone: sound server killed": lambda: server(signal.SIGKILL),
    "microphone: sound server hangs": lambda: server(signal.SIGSTOP),
    "microphone: recognizer raises": lambda: recognizer('raise RuntimeError("out of order")'),
    "microphone: recognizer hangs": lambda: recognizer("time.sleep(3)"),
    "microphone: recognizer takes twice the time": lambda: recognizer("time.sleep(0.06)"),
    "page: closed": lambda: page(lambda page: page.socket.close()),
    "page: answers no more": lambda: page(lambda page: setattr(page, "there", False)),
    "robot: raises": lambda: own_robot("raise OSError(5)"),
    "robot: hangs": lambda: own_robot("time.sleep(3)"),
    "voz: SIGTERM": ended,
    "voz: kill -9": killed,
    "ROS 1: kill -9 of the recognizer": lambda: ros1(lambda _, node, speaking: speaking.kill()),
    "ROS 1: kill -9 of the master": lambda: ros1(lambda ros, *_: ros.master.kill()),
    "ROS 1: SIGTERM to control_voz": lambda: ros1(lambda _, node, *__: node.process.terminate()),
    "ROS 1: kill -9 of control_voz": lambda: ros1(lambda _, node, *__: node.kill()),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=3, help="of each fault")
    parser.add_argument("--only", default="", metavar="WORD", help="faults with this in their name")
    arguments = parser.parse_args()
    print(f"{machine()}\n\n| {arguments.times} times each | median | longest |\n|---|---|---|")
    for name, fault in FAULTS.items():
        if arguments.only in name:
            took = []
            for _ in range(arguments.times):
                with tempfile.TemporaryDirectory(prefix="voz-faults-") as folder:
                    os.chdir(folder)
                    took.append(fault())
                    os.chdir(ROOT)
            print(f"| {name} | {np.median(took):.2f} s | {max(took):.2f} s |", flush=True)


if __name__ == "__main__":
    main()
