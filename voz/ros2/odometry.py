"""Where a robot is: a simulated one for RViz, as `odom` and `/tf`; a real one by its own `odom`."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from voz.control.bounded_motion import Place
from voz.ros2 import message_types as msg
from voz.ros2.node import Ros2Node, write
from voz.simulation.world import WorldState

ODOM = "odom"
"""The topic, and the frame that has its origin in a corner of the room."""

MOST_TAKEN = 100
"""Messages at a time; a base sends fewer in a beat."""

LATELY = 0.5
"""Odometry that is older is none, s."""


class Ros2OdometryPublisher:
    """Publishes `nav_msgs/Odometry` on `odom` and the transform of the base on `/tf`."""

    def __init__(self, node: Ros2Node, base: str) -> None:
        """Offer the topics.

        Args:
            node: publishes them.
            base: the base's own frame.
        """
        self._base = base
        self._odom = node.writer(ODOM, msg.Odometry)
        self._tf = node.writer("/tf", msg.TFMessage)

    def publish(self, state: WorldState) -> None:
        """Tell where the robot is now.

        Raises:
            RobotError: it cannot be published.
        """
        header = msg.header(ODOM)
        write(self._odom, _odometry(state, header, self._base))
        write(self._tf, msg.TFMessage([_transform(state, header, self._base)]))


def _odometry(state: WorldState, header: msg.HeaderMessage, base: str) -> msg.Odometry:
    pose = msg.Pose(msg.Point(state.pose.x, state.pose.y), _rotation(state))
    return msg.Odometry(
        header,
        base,
        msg.PoseWithCovariance(pose),
        msg.TwistWithCovariance(msg.velocity(state.linear, state.angular)),
    )


def _transform(state: WorldState, header: msg.HeaderMessage, base: str) -> msg.TransformStamped:
    place = msg.Vector3(state.pose.x, state.pose.y)
    return msg.TransformStamped(header, base, msg.Transform(place, _rotation(state)))


def _rotation(state: WorldState) -> msg.Quaternion:
    z, w = state.pose.quaternion()
    return msg.Quaternion(z=z, w=w)


class Ros2OdometryListener:
    """Knows where a base says that it is, as long as it says so, and how fast it is."""

    def __init__(
        self, node: Ros2Node, topic: str, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Read the topic of its `nav_msgs/Odometry`, whatever quality of service it offers.

        Args:
            node: reads it.
            topic: its name.
            clock: tells when a message came, s.
        """
        self._reader = node.any_reader(topic, msg.Odometry)
        self._clock = clock
        self._newest: tuple[float, msg.Odometry] | None = None

    def newest(self) -> tuple[float, msg.Odometry] | None:
        """What it last said, and when, s; None if nothing. Waits for nothing."""
        for message in self._reader.take(MOST_TAKEN):
            if isinstance(message, msg.Odometry):  # else it tells that a writer is gone
                self._newest = self._clock(), message
        return self._newest

    def place(self) -> Place | None:
        """Where it is; None if it did not say so lately. Waits for nothing."""
        newest = self.newest()
        if newest is None or self._clock() - newest[0] >= LATELY:
            return None
        pose = newest[1].pose.pose
        heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
        return pose.position.x, pose.position.y, math.remainder(heading, math.tau)
