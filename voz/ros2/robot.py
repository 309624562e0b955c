"""A robot on ROS 2: publishes velocity, selected object, commands and odometry."""

from __future__ import annotations

import time
from collections.abc import Callable

from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy

from voz.config import default_commands
from voz.control.bounded_motion import Place
from voz.control.safety import ends_goals
from voz.control.table import CommandTable
from voz.events import Attention, Event, Notice, Publish, SelectedObject, Twist, Utterance
from voz.robot.base import Robot
from voz.robot.other_senders import OtherSenders
from voz.ros2 import message_types as msg
from voz.ros2.diagnosis import Diagnosis
from voz.ros2.goals import GoalCanceller
from voz.ros2.liveness import SubscriberLiveness
from voz.ros2.node import FINAL_ACK_TIMEOUT, Ros2Node, all_acknowledged, write
from voz.ros2.odometry import Ros2OdometryListener, Ros2OdometryPublisher
from voz.ros2.other_recognizer import ROS2_SOURCE
from voz.ros2.subscribers import MAX_NEW_ENDPOINTS, MatchedReaders, OtherWriters
from voz.ros2.velocity import VelocityTopic
from voz.settings import Ros2

DIAGNOSTICS_INTERVAL = 1.0
"""Time between two messages on `/diagnostics`, s."""


class Ros2Robot(Robot):
    """Publishes events and the place of a simulated robot; lost without a subscriber."""

    def __init__(
        self,
        settings: Ros2,
        warn: Callable[[Notice], None] = lambda _: None,
        table: CommandTable | None = None,
    ) -> None:
        """Remember what to do; `open` does it.

        Args:
            settings: the domain, the topics and their types.
            warn: called when subscribers and other senders of velocities come and go, from within
                `open` and `receive`.
            table: the commands' own topics, and which commands stop the robot.
        """
        self._table = table or default_commands()
        self._settings = settings
        self._warn = warn
        self._liveness = SubscriberLiveness()
        self._diagnosis = Diagnosis()
        self._names: dict[int, str] = {}
        self._obstacle: str | None = None
        self._diagnosed = -DIAGNOSTICS_INTERVAL
        self._odometry: Ros2OdometryPublisher | None = None
        self._base: Ros2OdometryListener | None = None
        self._awake: DataWriter[msg.Bool] | None = None

    def open(self) -> None:
        """Join the domain and wait for a base, for a time.

        Raises:
            ConfigError: an environment variable is invalid.
            RobotError: the domain cannot be joined.
        """
        settings = self._settings
        self._node = node = Ros2Node(settings)
        self._topic = node.name(settings.cmd_vel)
        self._velocities = VelocityTopic(node, settings)
        self._selected_object = node.writer(settings.selected_object, msg.Int16)
        self._others = {
            topic: node.writer(topic, msg.MESSAGE_TYPES[kind])
            for topic, kind in self._table.topics.items()
        }
        self._output = node.writer(settings.output, msg.String)
        self._diagnostics = node.writer(settings.diagnostics, msg.DiagnosticArray)
        self._goals = GoalCanceller(node, settings.cancel)
        if self.where:
            self._odometry = Ros2OdometryPublisher(node, settings.frame_id)
        else:
            self._base = Ros2OdometryListener(node, settings.odom)
        self._listeners = MatchedReaders(node, self._velocities.writer)
        self._writers = OtherWriters(node, self._velocities.writer)
        self._senders = OtherSenders(self._topic, self._warn)
        self._velocities.wait_for_listener(settings.wait)
        self._look_around(0.0)
        self._senders.update(0.0, self._writers.names())

    def receive(self, event: Event) -> None:
        """Publish the event, if ROS 2 has a topic for it."""
        self._diagnosis.receive(event)
        if isinstance(event, Twist):
            try:
                handles = self._listeners.handles()
                answered = all_acknowledged(self._velocities.writer, 0.0)
                self._liveness.update(time.monotonic(), handles, answered)
            finally:  # whatever is wrong with the listeners: it may be a zero
                self._velocities.publish(event)
            self._goals.look()
            self._senders.update(event.t, self._writers.names(MAX_NEW_ENDPOINTS))
            if self._odometry and self.where:
                self._odometry.publish(self.where(event.t))
            if event.t - self._diagnosed >= DIAGNOSTICS_INTERVAL:
                self._look_around(event.t)
                self._diagnose(event.t)
            elif handles != self._names.keys():
                self._look_around(event.t)
        elif isinstance(event, SelectedObject):
            write(self._selected_object, msg.Int16(event.value))
        elif isinstance(event, Attention):
            self._write_awake(event.awake)
        elif isinstance(event, Publish):
            write(self._others[event.topic], msg.MESSAGE_TYPES[type(event.value)](event.value))
        elif ends_goals(event, self._table.halts):
            self._goals.cancel()
        if isinstance(event, Utterance) and event.obeyed and event.source != ROS2_SOURCE:
            write(self._output, msg.String(event.text.lower()))

    def place(self, t: float) -> Place | None:
        """Where the base says that it is."""
        base = self._base
        return base.place() if base else None

    def lost(self) -> str | None:
        """Return why no base can receive a velocity now; None if one can."""
        handles = self._listeners.handles()
        if self._liveness.alive(handles):
            return None
        if handles:
            names = " and ".join(self._names.get(handle, "somebody") for handle in handles)
            return f"{names} does not acknowledge {self._topic}"
        return self._obstacle or f"nobody listens to {self._topic}"

    def close(self) -> None:
        """Wait until the last velocity has arrived, cancel the goals of others, and leave."""
        all_acknowledged(self._velocities.writer, FINAL_ACK_TIMEOUT)
        self._goals.cancel()
        self._goals.wait()
        del self._goals, self._velocities, self._selected_object, self._output, self._diagnostics
        del self._others
        self._odometry = self._base = self._awake = None
        del self._listeners, self._writers, self._node

    def _write_awake(self, awake: bool) -> None:
        """Publish whether a robot with a name is awake; others have no such topic."""
        if self._awake is None:
            late = Policy.Durability.TransientLocal  # who subscribes later gets it too
            self._awake = self._node.writer(self._settings.awake, msg.Bool, late)
        write(self._awake, msg.Bool(awake))

    def _look_around(self, now: float) -> None:
        """Report subscribers that came and went; without any, find out why."""
        handles = self._listeners.handles()
        for handle in handles - self._names.keys():
            self._names[handle] = self._listeners.name(handle)
            self._warn(Notice(now, f"{self._names[handle]} listens to {self._topic}", good=True))
        for handle in self._names.keys() - handles:
            self._warn(Notice(now, f"{self._names.pop(handle)} left {self._topic}"))
        self._obstacle = None if handles else self._listeners.obstacle(self._topic)

    def _diagnose(self, now: float) -> None:
        self._diagnosed = now
        status = self._diagnosis.status(now, list(self._names.values()), self.lost())
        write(self._diagnostics, msg.DiagnosticArray(msg.header(""), [status]))
