"""Where a simulated robot is, as `odom` and `/tf`, so that RViz shows it."""

from __future__ import annotations

from voz.ros2 import messages
from voz.ros2.node import Node, write
from voz.simulation.world import WorldState

ODOM = "odom"
"""The topic, and the frame that has its origin in a corner of the room."""


class OdometryPublisher:
    """Publishes `nav_msgs/Odometry` on `odom` and the transform of the base on `/tf`."""

    def __init__(self, node: Node, base: str) -> None:
        """Offer the topics.

        Args:
            node: publishes them.
            base: the base's own frame.
        """
        self._base = base
        self._odom = node.writer(ODOM, messages.Odometry)
        self._tf = node.writer("/tf", messages.TFMessage)

    def publish(self, state: WorldState) -> None:
        """Tell where the robot is now.

        Raises:
            RobotError: it cannot be published.
        """
        header = messages.header(ODOM)
        write(self._odom, _odometry(state, header, self._base))
        write(self._tf, messages.TFMessage([_transform(state, header, self._base)]))


def _odometry(state: WorldState, header: messages.Header, base: str) -> messages.Odometry:
    pose = messages.Pose(messages.Point(state.pose.x, state.pose.y), _rotation(state))
    return messages.Odometry(
        header,
        base,
        messages.PoseWithCovariance(pose),
        messages.TwistWithCovariance(messages.velocity(state.linear, state.angular)),
    )


def _transform(state: WorldState, header: messages.Header, base: str) -> messages.TransformStamped:
    place = messages.Vector3(state.pose.x, state.pose.y)
    return messages.TransformStamped(header, base, messages.Transform(place, _rotation(state)))


def _rotation(state: WorldState) -> messages.Quaternion:
    z, w = state.pose.quaternion()
    return messages.Quaternion(z=z, w=w)
