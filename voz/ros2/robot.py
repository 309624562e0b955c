"""A robot on ROS 2: what voz wants becomes messages that any of its nodes can read."""

from __future__ import annotations

import time
from collections.abc import Callable

from voz.config import default_commands
from voz.control.bounded_motion import Place
from voz.control.safety import ends_goals
from voz.control.table import CommandTable
from voz.events import Event, Publish, SelectedObject, Twist, Utterance, Warning
from voz.robot.base import Robot
from voz.ros2 import message_types as msg
from voz.ros2.diagnosis import Diagnosis
from voz.ros2.goals import Goals
from voz.ros2.liveness import Audience
from voz.ros2.node import LAST_WORD, Ros2Node, answered, write
from voz.ros2.odometry import Ros2OdometryListener, Ros2OdometryPublisher
from voz.ros2.other_recognizer import HEARD_ON_ROS
from voz.ros2.subscribers import Endpoints, Listeners
from voz.ros2.velocity import VelocityTopic
from voz.settings import Ros2

DIAGNOSED = 1.0
"""From one message on `/diagnostics` to the next, s."""


class Ros2Robot(Robot):
    """Publishes what it receives, and where a simulated robot is; tells whether anybody listens."""

    def __init__(
        self,
        settings: Ros2,
        warn: Callable[[Warning], None] = lambda _: None,
        table: CommandTable | None = None,
    ) -> None:
        """Remember what to do; `open` does it.

        Args:
            settings: the domain, the topics and their types.
            warn: told who comes to listen and who leaves, from within `open` and `receive`.
            table: what commands publish besides, and which of them stop the robot.
        """
        self._table = table or default_commands()
        self._settings = settings
        self._warn = warn
        self._audience = Audience()
        self._diagnosis = Diagnosis()
        self._names: dict[int, str] = {}
        self._obstacle: str | None = None
        self._diagnosed = -DIAGNOSED
        self._odometry: Ros2OdometryPublisher | None = None
        self._base: Ros2OdometryListener | None = None

    def open(self) -> None:
        """Join the domain, and give a base the time to be found: until then no command counts.

        Raises:
            ConfigError: the environment says what cannot be.
            RobotError: the domain cannot be joined.
        """
        settings = self._settings
        self._node = node = Ros2Node(settings)
        self._topic = node.name(settings.cmd_vel)
        self._velocities = VelocityTopic(node, settings)
        self._selected_object = node.writer(settings.selected_object, msg.Int16)
        self._others = {
            topic: node.writer(topic, msg.HOLDS[kind]) for topic, kind in self._table.topics.items()
        }
        self._output = node.writer(settings.output, msg.String)
        self._diagnostics = node.writer(settings.diagnostics, msg.DiagnosticArray)
        self._goals = Goals(node, settings.cancel)
        if self.where:
            self._odometry = Ros2OdometryPublisher(node, settings.frame_id)
        else:
            self._base = Ros2OdometryListener(node, settings.odom)
        self._listeners = Listeners(Endpoints(node), self._velocities.writer)
        self._velocities.wait_for_listener(settings.wait)
        self._look_around(0.0)

    def receive(self, event: Event) -> None:
        """Publish the event, if ROS 2 has a topic for it."""
        self._diagnosis.receive(event)
        if isinstance(event, Twist):
            handles = self._listeners.handles()
            self._audience.note(time.monotonic(), handles, answered(self._velocities.writer, 0.0))
            self._velocities.publish(event)
            self._goals.look()
            if self._odometry and self.where:
                self._odometry.publish(self.where(event.t))
            if event.t - self._diagnosed >= DIAGNOSED:
                self._look_around(event.t)
                self._diagnose(event.t)
            elif handles != self._names.keys():
                self._look_around(event.t)
        elif isinstance(event, SelectedObject):
            write(self._selected_object, msg.Int16(event.value))
        elif isinstance(event, Publish):
            write(self._others[event.topic], msg.HOLDS[type(event.value)](event.value))
        elif ends_goals(event, self._table.halts):
            self._goals.cancel()
        if isinstance(event, Utterance) and event.obeyed and event.source != HEARD_ON_ROS:
            write(self._output, msg.String(event.text.lower()))

    def place(self, t: float) -> Place | None:
        """Where the base says that it is."""
        base = self._base
        return base.place() if base else None

    def lost(self) -> str | None:
        """Tell why no base can receive a velocity now; None if one can."""
        handles = self._listeners.handles()
        if self._audience.present(handles):
            return None
        if handles:
            names = " and ".join(self._names.get(handle, "somebody") for handle in handles)
            return f"{names} gives no answer to {self._topic}"
        return self._obstacle or f"nobody listens to {self._topic}"

    def close(self) -> None:
        """Wait until the last velocity has arrived, cancel the goals of others, and leave."""
        answered(self._velocities.writer, LAST_WORD)
        self._goals.cancel()
        self._goals.wait()
        del self._goals, self._velocities, self._selected_object, self._output, self._diagnostics
        del self._others
        self._odometry = self._base = None
        del self._listeners, self._node

    def _look_around(self, now: float) -> None:
        """Say who came and who went; if nobody is there, look why."""
        handles = self._listeners.handles()
        for handle in handles - self._names.keys():
            self._names[handle] = self._listeners.name(handle)
            self._warn(Warning(now, f"{self._names[handle]} listens to {self._topic}", good=True))
        for handle in self._names.keys() - handles:
            self._warn(Warning(now, f"{self._names.pop(handle)} left {self._topic}"))
        self._obstacle = None if handles else self._listeners.obstacle(self._topic)

    def _diagnose(self, now: float) -> None:
        self._diagnosed = now
        status = self._diagnosis.status(now, list(self._names.values()), self.lost())
        write(self._diagnostics, msg.DiagnosticArray(msg.header(""), [status]))
