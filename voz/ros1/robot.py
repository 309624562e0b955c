"""A robot on ROS 1: publishes velocity, selected object, commands; odometry both ways."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence, Set
from contextlib import suppress
from typing import Any

from voz.control.motion import Place, place_from_odometry
from voz.control.safety import zero_at_the_end
from voz.control.table import CommandTable
from voz.events import Event, Notice, Twist, Utterance
from voz.robot.base import Robot
from voz.robot.robot_process import RobotSpec
from voz.robot.ros_topics import OtherSenders, TopicRobot
from voz.robot.simulation.world import WorldState
from voz.ros1.master import WATCHDOG, other_senders
from voz.ros1.node import Ros1Node, subscribe
from voz.settings import Ros1

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


class Ros1Robot(TopicRobot):
    """Publishes the events on topics.

    `geometry_msgs/Twist` on `cmd_vel`, `std_msgs/Int16` on `selected_object`, and what is obeyed
    as `std_msgs/String` in lower case on `recognizer/output`; whether a robot with a name is awake,
    as `std_msgs/Bool` on `recognizer/awake`; the place of a simulated robot as
    `odom` and `tf`. A stop cancels the goals of other programs by an empty `actionlib_msgs/GoalID`.
    """

    def __init__(
        self,
        settings: Ros1,
        node: Ros1Node | None = None,
        arguments: Sequence[str] = (),
        says_heard: bool = True,
        *,
        table: CommandTable | None = None,
        warn: Callable[[Notice], None] = lambda _: None,
    ) -> None:
        """Prepare to publish.

        Args:
            settings: the names of the topics.
            node: the process's node; None makes one.
            arguments: remappings like `cmd_vel:=/base/cmd_vel`, for a node that is made.
            says_heard: False if the commands come from that topic.
            table: the commands' own topics, and which commands stop the robot.
            warn: called when other senders of velocities come and go, from within `open` and
                `receive`.
        """
        super().__init__(table)
        self._warn = warn
        self._other_names: Set[str] = frozenset()
        self._others: dict[str, Any] = {}
        self._settings = settings
        self._own = node is None
        self._node = node
        self._arguments = arguments
        self._says_heard = says_heard
        self._lock = threading.Lock()
        self._ended = False
        self._velocity: Any = None
        self._selected: Any = None
        self._heard: Any = None
        self._awake: Any = None
        self._odometry: Ros1OdometryPublisher | None = None
        self._base: Ros1OdometryListener | None = None
        self._goals: list[Any] = []

    def open(self) -> None:
        """Join ROS and advertise the topics; raises RobotError if there is no master."""
        self._node = self._node or Ros1Node(self._settings.node, self._arguments)
        from actionlib_msgs.msg import GoalID
        from rospy import Publisher
        from std_msgs.msg import Int16, String

        names = self._settings
        self._velocity = velocity_topic(names, self._node.name)
        self._senders = OtherSenders(self._velocity.resolved_name, self._warn)
        self._selected = Publisher(names.selected_object, Int16, queue_size=10)
        if self._says_heard:
            self._heard = Publisher(names.recognizer_output, String, queue_size=10)
        for topic, kind in self.table.topics.items():
            self._others[topic] = Publisher(topic, _message(kind), queue_size=10)
        self._goals = [Publisher(f"{name}/cancel", GoalID, queue_size=1) for name in names.cancel]
        if self.where:
            self._odometry = Ros1OdometryPublisher()
        else:
            self._base = Ros1OdometryListener(names.odom)
        self._node.on_shutdown(self._stop)
        self._node.each_second("voz-ros-senders", self._look_for_senders)
        with suppress(OSError):
            self._look_for_senders()
        self._senders.update(0.0, self._other_names)

    def publish_velocity(self, event: Twist) -> None:
        """Publish a velocity without waiting; zero while ROS is lost."""
        with self._lock:
            if self._ended:
                return
            lost = self.lost()
            self._publish_velocity(*((0.0, 0.0) if lost else (event.linear, event.angular)))
        if self._odometry and self.where:
            self._odometry.publish(self.where(event.t))
        self._senders.update(event.t, self._other_names)

    def publish_selected_object(self, number: int) -> None:
        """Publish the number of an object."""
        self._selected.publish(number)

    def publish_awake(self, awake: bool) -> None:
        """Publish whether a robot with a name is awake."""
        from rospy import Publisher
        from std_msgs.msg import Bool

        if self._awake is None:
            self._awake = Publisher(self._settings.awake, Bool, queue_size=10, latch=True)
        self._awake.publish(awake)

    def publish_value(self, topic: str, value: bool | int | float | str) -> None:
        """Publish a value on a command's own topic."""
        self._others[topic].publish(value)

    def publish_command(self, utterance: Utterance) -> None:
        """Publish a command that is obeyed."""
        if self._heard:
            self._heard.publish(utterance.text)

    def cancel_goals(self) -> None:
        """Cancel the goals of other programs."""
        for goals in self._goals:
            goals.publish()  # no goal's name means all

    def place(self, t: float) -> Place | None:
        """Where the base says that it is."""
        return self._base.place() if self._base else None

    def lost(self) -> str | None:
        """Return why ROS cannot be reached now; None if it can."""
        return self._node.trouble() if self._node else "ROS was not joined yet"

    def close(self) -> None:
        """Leave ROS with zero velocity as the last message."""
        if self._node and self._velocity:
            self._stop()
        if self._node and self._own:
            self._node.close()

    def _stop(self) -> None:
        """Publish zero, and no velocity after it: another thread may be about to."""
        with self._lock:
            self._ended = True
            with zero_at_the_end(lambda: self._publish_velocity(0.0, 0.0)):
                self.cancel_goals()

    def _look_for_senders(self) -> None:
        """Ask the master, which may take long, who else sends velocities; raises OSError."""
        assert self._node
        self._other_names = other_senders(self._velocity.resolved_name, self._node.name)

    def _publish_velocity(self, linear: float, angular: float) -> None:
        self._velocity.publish(velocity(linear, angular))


class Ros1Watchdog(Robot):
    """A node in another process, which can only stop the robot."""

    def __init__(self, spec: RobotSpec) -> None:
        """Prepare to publish, on the same topic as the robot that the spec names."""
        self._settings = spec.settings.ros1
        self._arguments = spec.arguments

    def open(self) -> None:
        """Join ROS; raises RobotError if there is no master."""
        self._node = Ros1Node(f"{self._settings.node}{WATCHDOG}", self._arguments)
        self._topic = velocity_topic(self._settings, self._node.name.removesuffix(WATCHDOG))

    def receive(self, event: Event) -> None:
        """Publish a velocity."""
        if isinstance(event, Twist):
            self._topic.publish(velocity(event.linear, event.angular))

    def lost(self) -> str | None:
        """Return why it cannot stop the base; it can without a master."""
        return "its node was ended" if self._node.over else None

    def close(self) -> None:
        """Leave ROS."""
        self._node.close()


def _message(kind: type) -> Any:
    from std_msgs import msg

    return {bool: msg.Bool, int: msg.Int32, float: msg.Float64, str: msg.String}[kind]


def velocity_topic(names: Ros1, node: str) -> Any:
    """Return the publisher of velocities of a node, by its full name; a watchdog has its node's."""
    from geometry_msgs.msg import Twist as Velocity
    from rosgraph.names import resolve_name
    from rospy import Publisher

    # A base wants the latest velocity; what waits for a slow one is out of date. With Nagle's
    # algorithm a stop would also wait until the message just before it is acknowledged.
    topic = resolve_name(names.cmd_vel, node)  # `~cmd_vel` is below the node
    return Publisher(topic, Velocity, queue_size=1, tcp_nodelay=True)


def velocity(linear: float, angular: float) -> Any:
    """Return the message of a velocity in m/s and rad/s."""
    from geometry_msgs.msg import Twist as Velocity

    message = Velocity()
    message.linear.x = linear
    message.angular.z = angular
    return message
