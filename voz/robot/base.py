"""The one thing that a robot has to do."""

from __future__ import annotations

from typing import Protocol

from voz.events import Event


class Robot(Protocol):
    """Anything that receives the events of a run.

    A robot that only rolls is four lines:

        class Wheels:
            def receive(self, event: Event) -> None:
                if isinstance(event, Twist):
                    self.motors.set(event.linear, event.angular)
    """

    def receive(self, event: Event) -> None:
        """Take one event, in the order of time; a `Twist` comes 10 times a second."""
