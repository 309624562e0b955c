"""Odometry: published for a simulated robot, with `tf` for RViz; received from a real one."""

from __future__ import annotations

import time
from typing import Any

from voz.control.bounded_motion import Place, place_from_odometry
from voz.robot.simulation.world import WorldState
from voz.ros1.node import subscribe

ODOM_FRAME, BASE_FRAME = "odom", "base_link"
"""The frames; the first has its origin in a corner of the room."""


class Ros1OdometryPublisher:
    """Publishes `nav_msgs/Odometry` on `odom` and the transform of the base on `/tf`."""

    def __init__(self) -> None:
        from nav_msgs.msg import Odometry
        from rospy import Publisher
        from tf2_msgs.msg import TFMessage

        self._odom = Publisher("odom", Odometry, queue_size=10)
        self._tf = Publisher("/tf", TFMessage, queue_size=10)

    def publish(self, state: WorldState) -> None:
        """Publish the state of now."""
        from rospy import Time
        from tf2_msgs.msg import TFMessage

        now = Time.now()
        self._odom.publish(_odometry(state, now))
        self._tf.publish(TFMessage([_transform(state, now)]))


def _odometry(state: WorldState, now: Any) -> Any:
    from nav_msgs.msg import Odometry

    message = Odometry()
    message.header.stamp, message.header.frame_id = now, ODOM_FRAME
    message.child_frame_id = BASE_FRAME
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y = state.pose.x, state.pose.y
    orientation.z, orientation.w = state.pose.quaternion()
    message.twist.twist.linear.x = state.linear
    message.twist.twist.angular.z = state.angular
    return message


def _transform(state: WorldState, now: Any) -> Any:
    from geometry_msgs.msg import TransformStamped

    message = TransformStamped()
    message.header.stamp, message.header.frame_id = now, ODOM_FRAME
    message.child_frame_id = BASE_FRAME
    place, rotation = message.transform.translation, message.transform.rotation
    place.x, place.y = state.pose.x, state.pose.y
    rotation.z, rotation.w = state.pose.quaternion()
    return message


class Ros1OdometryListener:
    """Receives the odometry of a base."""

    def __init__(self, topic: str) -> None:
        """Subscribe to the topic of its `nav_msgs/Odometry`."""
        from nav_msgs.msg import Odometry

        self._newest: tuple[float, Any] | None = None
        subscribe(topic, Odometry, self._note, queue_size=1)

    def newest(self) -> tuple[float, Any] | None:
        """The last message and its time by the monotonic clock, s."""
        return self._newest

    def place(self) -> Place | None:
        """Where the base is; None without recent odometry."""
        return place_from_odometry(self._newest, time.monotonic())

    def _note(self, message: Any) -> None:
        self._newest = time.monotonic(), message
