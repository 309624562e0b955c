"""A robot on ROS 2: publishes velocity, selected object, commands, odometry and its status."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any
from uuid import UUID

from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy

from voz.control.motion import Place
from voz.control.table import CommandTable
from voz.events import Event, Notice, Twist, Utterance
from voz.robot.console import motion_in_words
from voz.robot.ros_topics import OtherSenders, TopicRobot
from voz.ros2 import message_types as msg
from voz.ros2.base_topics import Ros2OdometryListener, Ros2OdometryPublisher, VelocityTopic
from voz.ros2.message_types import CancelAllGoals, CycloneCancelAllGoals, DiagnosticStatus, KeyValue
from voz.ros2.node import FINAL_ACK_TIMEOUT, Ros2Node, all_acknowledged, write
from voz.ros2.other_recognizer import ROS2_SOURCE
from voz.ros2.subscribers import (
    MAX_NEW_ENDPOINTS,
    Endpoints,
    MatchedReaders,
    OtherWriters,
    SubscriberLiveness,
)
from voz.settings import Ros2

OK, WARN = 0, 1

WARNING_SHOWN_TIME = 10.0
"""How long a warning is shown, s; a slow monitor sees it too."""


class Diagnosis:
    """Makes the status on `/diagnostics` from events."""

    def __init__(self) -> None:
        self._velocity = (0.0, 0.0)
        self._heard = ""
        self._confidence = 0.0
        self._obeyed = 0
        self._refused = 0
        self._warning: Notice | None = None

    def receive(self, event: Event) -> None:
        """Take an event."""
        if isinstance(event, Twist):
            self._velocity = (event.linear, event.angular)
        elif isinstance(event, Notice):
            self._warning = self._warning if event.good else event
        elif isinstance(event, Utterance):
            self._heard, self._confidence = event.text, event.confidence
            self._obeyed += event.obeyed is True
            self._refused += not event.obeyed

    def status(self, now: float, listeners: Sequence[str], trouble: str | None) -> DiagnosticStatus:
        """Return the status at a time of the run, s."""
        warning = self._warning
        if trouble is None and warning and now - warning.t < WARNING_SHOWN_TIME:
            trouble = warning.text
        linear, angular = self._velocity
        values = {
            "linear": f"{linear:g}",
            "angular": f"{angular:g}",
            "last heard": self._heard,
            "confidence": f"{self._confidence:.2f}",
            "obeyed": str(self._obeyed),
            "refused": str(self._refused),
            "listeners": ", ".join(listeners),
        }
        return DiagnosticStatus(
            level=WARN if trouble else OK,
            name="voz: voice control",
            message=trouble or f"robot {motion_in_words(linear, angular)}",
            hardware_id="voz",
            values=[KeyValue(key, value) for key, value in values.items()],
        )


CYCLONE_VENDOR = bytes([1, 16])
"""The vendor number with which Cyclone's endpoint numbers begin."""


class GoalCanceller:
    """Cancels all goals of some actions, such as Nav2's, whose servers may come and go.

    Attributes:
        requests: a writer for each action that has a server, by the service.
    """

    def __init__(self, node: Ros2Node, actions: Sequence[str]) -> None:
        """Prepare to cancel the goals of actions, in this order."""
        self._node = node
        self._arriving = Endpoints(node)
        self._services = [f"{action}/_action/cancel_goal" for action in actions]
        self.requests: dict[str, DataWriter[Any]] = {}

    def look(self) -> None:
        """Make a writer of requests for each new server; of several, for the last.

        Fast DDS would wait forever for a request in Cyclone's longer format.
        """
        new = self._arriving.new(MAX_NEW_ENDPOINTS).values()
        arrived = {one.topic_name: one.key for one in new}
        for service in self._services:
            server = arrived.get(self._node.request_topic(service))
            if server is None:
                continue
            kind, before = _layout(server), self.requests.get(service)
            if before is None or before.topic.data_type is not kind:
                self.requests.pop(service, None)
                self.requests[service] = self._node.requests(service, kind)

    def cancel(self) -> None:
        """Request the end of all goals without waiting; raises RobotError as `write`."""
        for service in self._services:
            if service in self.requests:
                requests = self.requests[service]
                write(requests, requests.topic.data_type())

    def wait(self) -> None:
        """Wait a short time until the requests have arrived."""
        until = time.monotonic() + FINAL_ACK_TIMEOUT
        for requests in self.requests.values():
            all_acknowledged(requests, max(0.0, until - time.monotonic()))


def _layout(key: UUID) -> type[CancelAllGoals | CycloneCancelAllGoals]:
    return CycloneCancelAllGoals if key.bytes.startswith(CYCLONE_VENDOR) else CancelAllGoals


DIAGNOSTICS_INTERVAL = 1.0
"""Time between two messages on `/diagnostics`, s."""


class Ros2Robot(TopicRobot):
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
        super().__init__(table)
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
            for topic, kind in self.table.topics.items()
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

    @property
    def writers(self) -> list[DataWriter[Any]]:
        """All that it publishes and requests with while it is open."""
        writers = [self._velocities.writer, self._selected_object, self._output, self._diagnostics]
        writers += [*self._others.values(), *self._goals.requests.values()]
        return writers + ([self._odometry.odom] if self._odometry else [])

    def receive(self, event: Event) -> None:
        """Publish the event, if ROS 2 has a topic for it."""
        self._diagnosis.receive(event)
        super().receive(event)

    def publish_velocity(self, event: Twist) -> None:
        """Publish a velocity; look who listens and who else sends."""
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

    def publish_selected_object(self, number: int) -> None:
        """Publish the number of an object."""
        write(self._selected_object, msg.Int16(number))

    def publish_awake(self, awake: bool) -> None:
        """Publish whether a robot with a name is awake."""
        if self._awake is None:
            late = Policy.Durability.TransientLocal  # who subscribes later gets it too
            self._awake = self._node.writer(self._settings.awake, msg.Bool, late)
        write(self._awake, msg.Bool(awake))

    def publish_value(self, topic: str, value: bool | int | float | str) -> None:
        """Publish a value on a command's own topic."""
        write(self._others[topic], msg.MESSAGE_TYPES[type(value)](value))

    def publish_command(self, utterance: Utterance) -> None:
        """Publish a command that is obeyed, unless another recognizer has published it."""
        if utterance.source != ROS2_SOURCE:
            write(self._output, msg.String(utterance.text.lower()))

    def cancel_goals(self) -> None:
        """Cancel the goals of other programs."""
        self._goals.cancel()

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
