"""Odometry: published for a simulated robot, with `/tf` for RViz; received from a real one."""

from __future__ import annotations

import time
from collections.abc import Callable

from voz.control.bounded_motion import Place, place_from_odometry
from voz.robot.simulation.world import WorldState
from voz.ros2 import message_types as msg
from voz.ros2.node import Ros2Node, take, write

ODOM = "odom"
"""The topic, and the frame that has its origin in a corner of the room."""

MAX_TAKEN = 100
"""Messages at a time; a base sends fewer in a beat."""


class Ros2OdometryPublisher:
    """Publishes `nav_msgs/Odometry` on `odom` and the transform of the base on `/tf`."""

    def __init__(self, node: Ros2Node, base: str) -> None:
        """Offer the topics; `base` is the frame of the base."""
        self._base = base
        self._odom = node.writer(ODOM, msg.Odometry)
        self._tf = node.writer("/tf", msg.TFMessage)

    def publish(self, state: WorldState) -> None:
        """Publish the state of now; raises RobotError."""
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
    """Receives the odometry of a base."""

    def __init__(
        self, node: Ros2Node, topic: str, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Read a topic of `nav_msgs/Odometry`, reliable or not; `clock` returns seconds."""
        self._reader = node.any_reader(topic, msg.Odometry)
        self._clock = clock
        self._newest: tuple[float, msg.Odometry] | None = None

    def newest(self) -> tuple[float, msg.Odometry] | None:
        """Return the last message and its time, s, without waiting."""
        for message in take(self._reader, MAX_TAKEN):
            self._newest = self._clock(), message
        return self._newest

    def place(self) -> Place | None:
        """Return where the base is, without waiting; None without recent odometry."""
        newest = self.newest()
        return place_from_odometry(newest, self._clock())
