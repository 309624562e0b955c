"""What the robots of ROS 1 and ROS 2 share: which event goes to which topic, and who else sends."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Set

from voz.config import default_commands
from voz.control.safety import ends_goals
from voz.control.table import CommandTable
from voz.events import Attention, Event, Notice, Publish, SelectedObject, Twist, Utterance
from voz.robot.base import Robot

ONE_SENDER = "let only one program send, or a multiplexer such as twist_mux choose"
"""What to do about two."""


class TopicRobot(Robot, ABC):
    """Publishes each event on its topic; subclasses know how to publish."""

    def __init__(self, table: CommandTable | None) -> None:
        """Take the commands' own topics, and which commands stop the robot; None is voz's own."""
        self.table = table or default_commands()

    def receive(self, event: Event) -> None:
        """Publish an event, if there is a topic for it; what stops the robot ends others' goals."""
        if isinstance(event, Twist):
            self.publish_velocity(event)
        elif isinstance(event, SelectedObject):
            self.publish_selected_object(event.value)
        elif isinstance(event, Attention):
            self.publish_awake(event.awake)
        elif isinstance(event, Publish):
            self.publish_value(event.topic, event.value)
        elif ends_goals(event, self.table.halts):
            self.cancel_goals()
        if isinstance(event, Utterance) and event.obeyed:
            self.publish_command(event)

    @abstractmethod
    def publish_velocity(self, event: Twist) -> None:
        """Publish a velocity, and what goes with each beat."""

    @abstractmethod
    def publish_selected_object(self, number: int) -> None:
        """Publish the number of an object, or 100 to fold the arm."""

    @abstractmethod
    def publish_awake(self, awake: bool) -> None:
        """Publish whether a robot with a name is awake; others have no such topic."""

    @abstractmethod
    def publish_value(self, topic: str, value: bool | int | float | str) -> None:
        """Publish a value on a command's own topic."""

    @abstractmethod
    def publish_command(self, utterance: Utterance) -> None:
        """Publish the text of a command that is obeyed, unless it came from that topic."""

    @abstractmethod
    def cancel_goals(self) -> None:
        """Cancel the goals of other programs, such as Nav2; zero velocity does not end them."""


class OtherSenders:
    """Warns of other programs that drive the same base: it obeys them too after a `stop` of voz.

    Pure: a warning of each that comes, and good news of each that goes.
    """

    def __init__(self, topic: str, warn: Callable[[Notice], None]) -> None:
        """Begin with nobody; the topic's name is for messages."""
        self._topic = topic
        self._warn = warn
        self._known: Set[str] = frozenset()

    def update(self, now: float, names: Set[str]) -> None:
        """Note who sends now, by names for people; `now` is the time of the run, s."""
        for name in sorted(names - self._known):
            text = f"{name} sends velocities on {self._topic} too: {ONE_SENDER}"
            self._warn(Notice(now, text))
        for name in sorted(self._known - names):
            self._warn(Notice(now, f"{name} left {self._topic}", good=True))
        self._known = names
