"""The topic of the velocities, and what stops the robot there from another process."""

from __future__ import annotations

from typing import Any

from cyclonedds.pub import DataWriter
from cyclonedds.qos import BasePolicy

from voz.config import Ros2
from voz.events import Event, Twist
from voz.robot.base import Robot
from voz.robot.process import Order
from voz.robot.ros2 import messages
from voz.robot.ros2.node import LAST_WORD, Node, answered, write


class VelocityTopic:
    """Publishes velocities, as Twist or as TwistStamped.

    Attributes:
        writer: of the topic.
    """

    def __init__(self, node: Node, settings: Ros2, *policies: BasePolicy) -> None:
        """Offer the topic.

        Args:
            node: publishes it.
            settings: its name and type.
            policies: what is offered besides that messages arrive.
        """
        self._settings = settings
        kind = messages.TwistStamped if settings.stamped else messages.Twist
        self.writer: DataWriter[Any] = node.writer(settings.cmd_vel, kind, *policies)

    def publish(self, event: Twist) -> None:
        """Publish a velocity; raises RobotError as `write` does."""
        twist = messages.velocity(event.linear, event.angular)
        if self._settings.stamped:
            write(self.writer, messages.stamped(twist, self._settings.frame_id))
        else:
            write(self.writer, twist)


class Ros2Watchdog(Robot):
    """A writer of its own besides the robot's: it can only stop the base.

    It offers no deadline: a base that asks for one notices by itself that the run is gone.
    """

    def __init__(self, order: Order) -> None:
        """Prepare to publish where the robot that the order names does."""
        self._settings = order.settings.ros2

    def open(self) -> None:
        """Join the domain; raises RobotError if that fails."""
        self._node = Node(self._settings)  # it ends with the last reference to it
        self._topic = VelocityTopic(self._node, self._settings)

    def receive(self, event: Event) -> None:
        """Publish a velocity."""
        if isinstance(event, Twist):
            self._topic.publish(event)

    def close(self) -> None:
        """Wait until the last velocity has arrived."""
        answered(self._topic.writer, LAST_WORD)
