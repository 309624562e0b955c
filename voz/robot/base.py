"""What a robot has to do: receive events. All else has a default."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from difflib import SequenceMatcher
from typing import TYPE_CHECKING

from voz.control.motion import Place
from voz.errors import RobotError
from voz.events import Event, Twist, Utterance

if TYPE_CHECKING:
    from voz.robot.simulation.world import WorldState

RECEIVING = ("move", "command", "receive")
"""The methods of which a robot has at least one of its own."""

LEAST_LIKENESS = 0.7
"""Of a method's name to one of those, from 0 to 1, for it to be meant."""


class Robot:
    """Anything that receives the events of a run.

    `[own.MODULE]` in voz.toml holds the arguments of a class of a user's in a file `MODULE.py`.

    A robot that only rolls is three lines; one that does other things has a `command`, too:

        class Wheels(Robot):
            def move(self, linear: float, angular: float) -> None:
                self.motors.set(linear, angular)

    Attributes:
        slow: whether what is no velocity may take long, as an arm that moves. Then `receive` gets
            those events on a thread of its own, one after the other, while velocities go on coming
            on the first one. A robot of a user's sets it in its class: `slow = True`.
        where: returns where a simulated robot of the same run is at a time, s; None if there is
            none, or this one is in another process.
    """

    slow = False
    where: Callable[[float], WorldState] | None = None

    def open(self) -> None:
        """Get ready; called once before the first event.

        Raises:
            RobotError: it cannot be reached.
        """

    def receive(self, event: Event) -> None:
        """Take one event, in the order of time; a `Twist` comes 10 times a second.

        Each robot has a thread of its own for this, and one of a user's a process too. If it takes
        too long, only the newest `Twist` is kept for it, and one that stops it comes before all
        else; if it takes more than 0.35 s it is lost, unless it is `slow` and the event is no
        `Twist`. An `Utterance` is a command for it if it is `obeyed`; `accepted` only says that it
        was understood. Unless a robot has its own `receive`, it gets those as `command`, and
        velocities as `move`.
        """
        if isinstance(event, Twist):
            self.move(event.linear, event.angular)
        elif isinstance(event, Utterance) and event.obeyed:
            self.command(event.name, event.slots)

    def move(self, linear: float, angular: float) -> None:
        """Hold a velocity; called 10 times a second.

        Args:
            linear: forward, m/s.
            angular: turning to the left, rad/s.
        """

    def command(self, name: str, slots: Mapping[str, str | float]) -> None:
        """Do what a command says; called when, and only when, it is obeyed.

        Args:
            name: of the command, as the list of commands has it.
            slots: what was said in its slots.
        """

    def place(self, t: float) -> Place | None:
        """Return where the robot is by its odometry; it must not wait for anything.

        Args:
            t: the time of the run, s.

        Returns:
            x and y, m, and the heading to the left of the x axis, rad; None if that is not known.
        """
        return None

    def lost(self) -> str | None:
        """Return why the robot cannot be reached now, or None; called after each event (S5)."""
        return None

    def close(self) -> None:
        """Release what `open` took; called once after the last event, which is zero velocity."""


def check_receives(robot: Robot) -> None:
    """Raise RobotError for a class whose robots would do nothing: its methods may be misspelt."""
    if type(robot) is Robot or any(_has_own(robot, name) for name in RECEIVING):
        return
    names = [name for name in dir(robot) if not (name.startswith("_") or name in dir(Robot))]
    near = [(_likeness(name, wanted), wanted) for name in names for wanted in RECEIVING]
    likeness, meant = max(near, default=(0.0, ""))
    raise RobotError(
        f"{type(robot).__name__} has none of {', '.join(RECEIVING)}",
        f"did you mean {meant}?" if likeness >= LEAST_LIKENESS else "write the one that it needs",
    )


def _has_own(robot: Robot, name: str) -> bool:
    return getattr(getattr(robot, name), "__func__", None) is not vars(Robot)[name]


def _likeness(name: str, wanted: str) -> float:
    return SequenceMatcher(None, name.lower().replace("_", ""), wanted).ratio()
