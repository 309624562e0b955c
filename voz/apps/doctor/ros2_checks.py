"""The subscribers to the velocities on ROS 2, and the base that is one; it needs cyclonedds."""

from __future__ import annotations

import os
import time
from collections.abc import Callable

from voz.apps.doctor.base_stop_check import (
    MeasuredMotion,
    Obstacle,
    motion_of,
    senders_obstacle,
)
from voz.apps.doctor.finding import Finding, senders_finding
from voz.events import Twist
from voz.ros2.base_topics import Ros2OdometryListener, VelocityTopic
from voz.ros2.node import Ros2Node, domain_number
from voz.ros2.subscribers import MatchedReaders, OtherWriters
from voz.settings import Ros2

ROS2 = "ROS 2"

DISCOVERY_TIME = 1.0
"""In which other programs in the domain are found, s."""


def check_subscribers(settings: Ros2) -> list[Finding]:
    """Check who listens to the velocities; raises VozError if the domain cannot be joined."""
    node = Ros2Node(settings)
    others_known = time.monotonic() + DISCOVERY_TIME
    velocities = VelocityTopic(node, settings, only_zero=True)
    velocities.wait_for_listener(settings.wait)
    there = MatchedReaders(node, velocities.writer)
    topic = node.name(settings.cmd_vel)
    names = sorted(there.name(handle) for handle in there.handles())
    if names:
        status, remedy = f"{' and '.join(names)} listens", None
    else:
        status = there.obstacle(topic) or "nobody listens"
        remedy = "start the base's driver, or look at ROS_DOMAIN_ID and at [ros2] in voz.toml"
    joined = f"domain {domain_number(settings, os.environ)} is joined"
    time.sleep(max(0.0, others_known - time.monotonic()))
    return [
        Finding(ROS2, True, joined),
        Finding(f"{ROS2} {topic}", bool(names), status, remedy),
        senders_finding(ROS2, topic, OtherWriters(node, velocities.writer).names()),
    ]


class Ros2Base:
    """The base that subscribes to the velocities."""

    def __init__(self, settings: Ros2, odometry: str, clock: Callable[[], float]) -> None:
        """Publish velocities, and subscribe to the topic of an odometry."""
        node = Ros2Node(settings)
        self._name = node.name(settings.cmd_vel)
        self._velocities = VelocityTopic(node, settings)
        self._others = OtherWriters(node, self._velocities.writer)
        self._odometry = Ros2OdometryListener(node, odometry, clock)

    def send(self, linear: float, angular: float) -> None:
        """Send a velocity once, m/s and rad/s."""
        self._velocities.publish(Twist(0.0, linear, angular))

    def motion(self) -> MeasuredMotion | None:
        """The newest odometry."""
        return motion_of(self._odometry.newest())

    def obstacle(self) -> Obstacle | None:
        """Return why it must not be driven now; None if it may be."""
        if not self._velocities.writer.get_matched_subscriptions():
            return Obstacle(f"nobody listens to {self._name}", "start the base's driver")
        return senders_obstacle(self._name, self._others.names())
