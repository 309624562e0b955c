"""The subscribers to the velocities on ROS 2, and the base that is one; it needs cyclonedds."""

from __future__ import annotations

import os
from collections.abc import Callable

from cyclonedds.builtin import BuiltinTopicDcpsPublication

from voz.apps.doctor.base_stop_check import MeasuredMotion, Obstacle, motion_of
from voz.apps.doctor.finding import Finding
from voz.events import Twist
from voz.ros2.discovery import domain_number
from voz.ros2.node import Ros2Node
from voz.ros2.odometry import Ros2OdometryListener
from voz.ros2.subscribers import Endpoints, MatchedReaders
from voz.ros2.velocity import VelocityTopic
from voz.settings import Ros2

ROS2 = "ROS 2"


def check_subscribers(settings: Ros2) -> list[Finding]:
    """Check who listens to the velocities; raises VozError if the domain cannot be joined."""
    node = Ros2Node(settings)
    velocities = VelocityTopic(node, settings)
    velocities.wait_for_listener(settings.wait)
    there = MatchedReaders(Endpoints(node), velocities.writer)
    topic = node.name(settings.cmd_vel)
    names = sorted(there.name(handle) for handle in there.handles())
    if names:
        status, remedy = f"{' and '.join(names)} listens", None
    else:
        status = there.obstacle(topic) or "nobody listens"
        remedy = "start the base's driver, or look at ROS_DOMAIN_ID and at [ros2] in voz.toml"
    joined = f"domain {domain_number(settings, os.environ)} is joined"
    return [
        Finding(ROS2, True, joined),
        Finding(f"{ROS2} {topic}", bool(names), status, remedy),
    ]


class Ros2Base:
    """The base that subscribes to the velocities."""

    def __init__(self, settings: Ros2, odometry: str, clock: Callable[[], float]) -> None:
        """Publish velocities, and subscribe to the topic of an odometry."""
        node = Ros2Node(settings)
        self._name = node.name(settings.cmd_vel)
        self._velocities = VelocityTopic(node, settings)
        self._writers = Endpoints(node, BuiltinTopicDcpsPublication)
        self._odometry = Ros2OdometryListener(node, odometry, clock)

    def send(self, linear: float, angular: float) -> None:
        """Send a velocity once, m/s and rad/s."""
        self._velocities.publish(Twist(0.0, linear, angular))

    def motion(self) -> MeasuredMotion | None:
        """The newest odometry."""
        return motion_of(self._odometry.newest())

    def obstacle(self) -> Obstacle | None:
        """Return why it must not be driven now; None if it may be."""
        writer = self._velocities.writer
        if not writer.get_matched_subscriptions():
            return Obstacle(f"nobody listens to {self._name}", "start the base's driver")
        if len(self._writers.of(writer.topic.name)) > 1:
            return Obstacle(f"another program sends velocities on {self._name} too", "end it first")
        return None
