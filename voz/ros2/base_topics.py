"""The topics of a base: velocity, with the watchdog that publishes zero on it, and odometry."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy

from voz.control.motion import Place, place_from_odometry
from voz.events import Event, Twist
from voz.robot.base import Robot
from voz.robot.robot_process import RobotSpec
from voz.robot.simulation.world import WorldState
from voz.ros2 import message_types as msg
from voz.ros2.node import FINAL_ACK_TIMEOUT, Ros2Node, all_acknowledged, take, write
from voz.ros2.subscribers import ONLY_ZERO
from voz.settings import Ros2

DEADLINE = 200_000_000
"""Promised limit between two velocities, ns: two beats."""

LEASE = 500_000_000
"""A base that asks for liveliness learns that no writer was alive for this time, ns."""


SUBSCRIBER_CHECK_INTERVAL = 0.02
"""Time between two looks for a subscriber, s."""

WATCHDOG_DISCOVERY_TIME = 3.0
"""How long the watchdog waits for a subscriber, s."""


class VelocityTopic:
    """Publishes velocities, as Twist or as TwistStamped.

    Attributes:
        writer: of the topic.
    """

    def __init__(self, node: Ros2Node, settings: Ros2, only_zero: bool = False) -> None:
        """Offer the topic of the settings; `only_zero` tells others that this moves nothing."""
        self._settings = settings
        self.writer: DataWriter[Any] = node.writer(
            settings.cmd_vel,
            msg.TwistStamped if settings.stamped else msg.TwistMessage,
            Policy.Deadline(DEADLINE),
            # Asserted by each velocity: a program that hangs is noticed like one that is gone.
            Policy.Liveliness.ManualByTopic(LEASE),
            mark=ONLY_ZERO if only_zero else b"",
        )

    def wait_for_listener(self, seconds: float) -> None:
        """Wait until there is a subscriber, at most some seconds."""
        until = time.monotonic() + seconds
        while not self.writer.get_matched_subscriptions() and time.monotonic() < until:
            time.sleep(SUBSCRIBER_CHECK_INTERVAL)

    def publish(self, event: Twist) -> None:
        """Publish a velocity; raises RobotError as `write` does."""
        twist = msg.velocity(event.linear, event.angular)
        if self._settings.stamped:
            write(self.writer, msg.stamped(twist, self._settings.frame_id))
        else:
            write(self.writer, twist)


class Ros2Watchdog(Robot):
    """Another writer of the topic, with the same offers, which can only stop the base.

    It is silent while all is well: a base that asks for liveliness sees one writer of two alive.
    """

    def __init__(self, spec: RobotSpec) -> None:
        """Prepare to publish where the robot that the spec names does."""
        self._settings = spec.settings.ros2

    def open(self) -> None:
        """Join the domain, and wait for the base; raises RobotError if that fails.

        What is sent before is lost, so a run must not begin before.
        """
        self._node = Ros2Node(self._settings)  # it ends with the last reference to it
        self._topic = VelocityTopic(self._node, self._settings, only_zero=True)
        self._topic.wait_for_listener(min(self._settings.wait, WATCHDOG_DISCOVERY_TIME))

    def receive(self, event: Event) -> None:
        """Publish a velocity."""
        if isinstance(event, Twist):
            self._topic.publish(event)

    def close(self) -> None:
        """Wait until the last velocity has arrived."""
        all_acknowledged(self._topic.writer, FINAL_ACK_TIMEOUT)


ODOM = "odom"
"""The topic, and the frame that has its origin in a corner of the room."""

MAX_TAKEN = 100
"""Messages at a time; a base sends fewer in a beat."""


class Ros2OdometryPublisher:
    """Publishes `nav_msgs/Odometry` on `odom` and the transform of the base on `/tf`."""

    def __init__(self, node: Ros2Node, base: str) -> None:
        """Offer the topics; `base` is the frame of the base."""
        self._base = base
        self.odom = node.writer(ODOM, msg.Odometry)  # the writer of the first
        self._tf = node.writer("/tf", msg.TFMessage)

    def publish(self, state: WorldState) -> None:
        """Publish the state of now; raises RobotError."""
        header = msg.header(ODOM)
        write(self.odom, _odometry(state, header, self._base))
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
