"""ROS 1: whether the master answers, who listens to `cmd_vel`, whether the base stops. An edge."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

from voz.apps.doctor.base_stop_check import (
    MeasuredMotion,
    Obstacle,
    motion_of,
    senders_obstacle,
)
from voz.apps.doctor.finding import Finding, failed, senders_finding
from voz.errors import ConfigError, RobotError
from voz.ros1.master import check_namespace, master_uri, other_senders, system_state
from voz.ros1.node import Ros1Node
from voz.ros1.robot import Ros1OdometryListener, velocity, velocity_topic
from voz.settings import Ros1

DOCTOR_NODE = "/voz_doctor"


def check_ros1(settings: Ros1, required: bool) -> Iterator[Finding]:
    """Check the ROS master, and who subscribes to the velocities."""
    if required:
        yield _check_rospy()
    name = "ROS 1 master"
    try:
        check_namespace()
        topic = full_name(settings.cmd_vel, settings.node)
        _, subscribers = system_state(DOCTOR_NODE)
        others = other_senders(topic, DOCTOR_NODE)
    except ConfigError as error:
        yield failed(name, error, required)
    except OSError as error:
        status = f"none at {master_uri()} ({error.strerror or error})"
        yield Finding(name, False, status, "start `roscore`, or set ROS_MASTER_URI", required)
    else:
        yield Finding(name, True, f"answers at {master_uri()}", required=required)
        yield _check_subscribers(topic, subscribers, required)
        yield senders_finding("ROS 1", topic, others)


def full_name(topic: str, node: str) -> str:
    """Return a topic's name with its namespace; of one that begins with ~, with the node's name."""
    if topic.startswith("/"):
        return topic
    namespace = os.environ.get("ROS_NAMESPACE", "").strip("/")
    return "/".join(["", *filter(None, [namespace]), topic.replace("~", f"{node}/", 1)])


def _check_rospy() -> Finding:
    if find_spec("rospy"):
        return Finding("ROS 1", True, f"{sys.executable} has rospy")
    status = f"{sys.executable} has no rospy"
    return Finding("ROS 1", False, status, "`make ros1`, then call .venv-ros1/bin/voz")


def _check_subscribers(topic: str, subscribers: dict[str, list[str]], required: bool) -> Finding:
    part = f"ROS 1 {topic}"
    if names := subscribers.get(topic):
        return Finding(part, True, f"{' and '.join(names)} listens", required=required)
    remedy = "start the base's driver, or name its topic: `cmd_vel` in [ros1] of voz.toml"
    return Finding(part, False, "nobody listens", remedy, required)


class Ros1Base:
    """The base that subscribes to the velocities."""

    def __init__(self, node: Ros1Node, settings: Ros1, odometry: str) -> None:
        """Publish velocities, and subscribe to the topic of an odometry."""
        self._node = node
        driver = f"{node.name.rpartition('/')[0]}/{settings.node}"
        self._velocity = velocity_topic(settings, driver)
        self._name = self._velocity.resolved_name
        self._odometry = Ros1OdometryListener(odometry)

    def send(self, linear: float, angular: float) -> None:
        """Send a velocity once, m/s and rad/s."""
        self._velocity.publish(velocity(linear, angular))

    def motion(self) -> MeasuredMotion | None:
        """The newest odometry."""
        return motion_of(self._odometry.newest())

    def obstacle(self) -> Obstacle | None:
        """Return why it must not be driven now; None if it may be."""
        if not self._velocity.get_num_connections():
            return Obstacle(f"nobody listens to {self._name}", "start the base's driver")
        try:
            return senders_obstacle(self._name, other_senders(self._name, self._node.name))
        except OSError:
            return Obstacle("the ROS master does not answer", "start it again")


@contextmanager
def open_ros1_base(settings: Ros1, odometry: str) -> Iterator[Ros1Base]:
    """Open the base for the length of a `with` block.

    Raises:
        RobotError: ROS 1 is not there.
        ConfigError: the namespace is invalid.
    """
    with Ros1Node("voz_doctor") as node:
        yield Ros1Base(node, settings, odometry)
        if node.over:
            raise RobotError("somebody ended the node; call it again")
