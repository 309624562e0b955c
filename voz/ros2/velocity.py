"""The topic of the velocities, and what stops the robot there from another process."""

from __future__ import annotations

import time
from typing import Any

from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy

from voz.events import Event, Twist
from voz.robot.base import Robot
from voz.robot.robot_process import RobotSpec
from voz.ros2 import message_types as msg
from voz.ros2.node import LAST_WORD, Ros2Node, answered, write
from voz.settings import Ros2

DEADLINE = 200_000_000
"""Between two velocities there is promised to be no more, ns: two beats."""

LEASE = 500_000_000
"""A base that asks for it is told when nobody who could drive it was alive for so long, ns."""


LOOK = 0.02
"""How often it looks whether somebody listens, s."""

FOUND = 3.0
"""How long the watchdog waits to be found, s; the robot's own writer was found before it."""


class VelocityTopic:
    """Publishes velocities, as Twist or as TwistStamped.

    Attributes:
        writer: of the topic.
    """

    def __init__(self, node: Ros2Node, settings: Ros2) -> None:
        """Offer the topic.

        Args:
            node: publishes it.
            settings: its name and type.
        """
        self._settings = settings
        self.writer: DataWriter[Any] = node.writer(
            settings.cmd_vel,
            msg.TwistStamped if settings.stamped else msg.TwistMessage,
            Policy.Deadline(DEADLINE),
            # Asserted by each velocity: a program that hangs is noticed like one that is gone.
            Policy.Liveliness.ManualByTopic(LEASE),
        )

    def wait_for_listener(self, seconds: float) -> None:
        """Wait until somebody listens, or for so long, s."""
        until = time.monotonic() + seconds
        while not self.writer.get_matched_subscriptions() and time.monotonic() < until:
            time.sleep(LOOK)

    def publish(self, event: Twist) -> None:
        """Publish a velocity; raises RobotError as `write` does."""
        twist = msg.velocity(event.linear, event.angular)
        if self._settings.stamped:
            write(self.writer, msg.stamped(twist, self._settings.frame_id))
        else:
            write(self.writer, twist)


class Ros2Watchdog(Robot):
    """A writer of its own besides the robot's: it can only stop the base.

    It offers what the robot's offers, so that whoever hears that one hears it too. As it is silent
    for as long as all is well, a base that asks for liveliness sees one writer of two alive.
    """

    def __init__(self, order: RobotSpec) -> None:
        """Prepare to publish where the robot that the order names does."""
        self._settings = order.settings.ros2

    def open(self) -> None:
        """Join the domain, and be found by the base; raises RobotError if that fails.

        What is sent before that is lost, so a run must not drive before.
        """
        self._node = Ros2Node(self._settings)  # it ends with the last reference to it
        self._topic = VelocityTopic(self._node, self._settings)
        self._topic.wait_for_listener(min(self._settings.wait, FOUND))

    def receive(self, event: Event) -> None:
        """Publish a velocity."""
        if isinstance(event, Twist):
            self._topic.publish(event)

    def close(self) -> None:
        """Wait until the last velocity has arrived."""
        answered(self._topic.writer, LAST_WORD)
