"""ROS 1: whether the master answers, who listens to `cmd_vel`, whether the base stops. An edge."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from voz.apps.doctor.finding import Finding, not_well
from voz.apps.doctor.stopping import MeasuredMotion, told_motion
from voz.errors import ConfigError, RobotError
from voz.ros1.master import ask, check_namespace, master_uri
from voz.ros1.node import Ros1Node
from voz.ros1.odometry import Ros1OdometryListener
from voz.ros1.robot import velocity, velocity_topic
from voz.settings import Ros1

CALLER = "/voz_doctor"


def ros1(settings: Ros1, needed: bool) -> Iterator[Finding]:
    """Look at ROS 1.

    Args:
        settings: the names of the topics.
        needed: whether this robot is driven by it.
    """
    if needed:
        yield _rospy()
    name = "ROS 1 master"
    try:
        check_namespace()
        _, subscribers = graph()
    except ConfigError as error:
        yield not_well(name, error, needed)
    except OSError as error:
        told = f"none at {master_uri()} ({error.strerror or error})"
        yield Finding(name, False, told, "start `roscore`, or set ROS_MASTER_URI", needed)
    else:
        yield Finding(name, True, f"answers at {master_uri()}", needed=needed)
        yield _listeners(full_name(settings.cmd_vel), subscribers, needed)


def graph() -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """Ask the master who publishes and who subscribes each topic; raises OSError."""
    publishers, subscribers, _ = ask("getSystemState", CALLER) or ([], [], [])
    return dict(publishers), dict(subscribers)


def full_name(topic: str) -> str:
    """A topic's name with its namespace."""
    if topic.startswith("/"):
        return topic
    namespace = os.environ.get("ROS_NAMESPACE", "").strip("/")
    return "/".join(["", *filter(None, [namespace]), topic])


def _rospy() -> Finding:
    if find_spec("rospy"):
        return Finding("ROS 1", True, f"{sys.executable} has rospy")
    told = f"{sys.executable} has no rospy"
    return Finding("ROS 1", False, told, "`make ros1`, then call .venv-ros1/bin/voz")


def _listeners(topic: str, subscribers: dict[str, list[str]], needed: bool) -> Finding:
    what = f"ROS 1 {topic}"
    if there := subscribers.get(topic):
        return Finding(what, True, f"{' and '.join(there)} listens", needed=needed)
    to_do = "start the base's driver, or name its topic: `cmd_vel` in [ros1] of voz.toml"
    return Finding(what, False, "nobody listens", to_do, needed)


class Ros1Base:
    """The base that listens to the topic of the velocities."""

    def __init__(self, node: Ros1Node, settings: Ros1, odometry: str) -> None:
        """Offer velocities, and listen to an odometry.

        Args:
            node: this process's.
            settings: the topic of the velocities.
            odometry: its topic.
        """
        self._node = node
        self._name = full_name(settings.cmd_vel)
        self._velocity = velocity_topic(settings)
        self._odometry = Ros1OdometryListener(odometry)

    def send(self, linear: float, angular: float) -> None:
        """Send a velocity once, m/s and rad/s."""
        self._velocity.publish(velocity(linear, angular))

    def motion(self) -> MeasuredMotion | None:
        """The newest odometry."""
        return told_motion(self._odometry.newest())

    def obstacle(self) -> str | None:
        """Why it must not be driven now; None if it may be."""
        if not self._velocity.get_num_connections():
            return f"nobody listens to {self._name}; start the base's driver"
        try:
            publishers, _ = graph()
        except OSError:
            return "the ROS master does not answer; start it again"
        others = [name for name in publishers.get(self._name, ()) if name != self._node.name]
        if others:
            return f"{' and '.join(others)} sends velocities too; end it first"
        return None


@contextmanager
def ros1_base(settings: Ros1, odometry: str) -> Iterator[Ros1Base]:
    """Reach the base for the length of a `with` block.

    Args:
        settings: the names of the topics.
        odometry: the topic on which the base tells how it moves.

    Raises:
        RobotError: ROS 1 is not there.
        ConfigError: the namespace cannot be.
    """
    with Ros1Node("voz_doctor") as node:
        yield Ros1Base(node, settings, odometry)
        if node.over:
            raise RobotError("somebody ended the node; call it again")
