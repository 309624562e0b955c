"""All ways by which a command goes out: what a robot, or a program, gets of it."""

from __future__ import annotations

import os
import pty
import threading
import tty
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from promises.run import Outcome

import voz
from voz.events import Event, Publish, Receiver, Reply, StartProgram, Twist, Utterance
from voz.robot.serial_port import open_serial_port
from voz.robot.simulation.simulator import SimulatedRobot
from voz.settings import Ros2, Simulator

Acts = Callable[[Outcome], Sequence[Any]]
"""Returns what came out, in order: velocities that move, or what else was done."""

Opened = tuple[Sequence[Receiver], Acts]


@dataclass(frozen=True)
class Exit:
    """A way by which commands go out."""

    name: str  # in the table
    open: Callable[[], Any]  # opens it; gives what gets the events, and what tells what came out
    text: str = "go forward"  # the command that comes out there
    moves: bool = True  # whether it is a velocity: zero has to be the last one
    # Which promises cannot be kept or broken here, and why.
    cannot: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.name


waved: list[str] = []
"""Who was greeted by the function that a command calls."""


def wave(whom: str) -> None:
    """What the command `wave` calls."""
    waved.append(whom)


class Receiving(voz.Robot):
    """A robot that takes events as they are."""

    def __init__(self) -> None:
        self.got: list[Any] = []

    def receive(self, event: Event) -> None:
        """Keep velocities, and what is obeyed."""
        if isinstance(event, Twist):
            self.got.append((event.linear, event.angular))
        elif isinstance(event, Utterance) and event.obeyed:
            self.got.append(event.name)


class Rolling(voz.Robot):
    """A robot that only rolls."""

    def __init__(self) -> None:
        self.got: list[Any] = []

    def move(self, linear: float, angular: float) -> None:
        """Keep a velocity."""
        self.got.append((linear, angular))


class Handy(voz.Robot):
    """A robot that only does what is said."""

    def __init__(self) -> None:
        self.got: list[Any] = []

    def command(self, name: str, slots: object) -> None:
        """Keep a command."""
        self.got.append(name)


def in_process(make: Callable[[], Any]) -> Callable[[], Any]:
    """Open a robot of a class, which keeps what it got."""

    @contextmanager
    def opened() -> Iterator[Opened]:
        robot = make()
        yield [robot.receive], lambda _: robot.got

    return opened


@contextmanager
def serial_port() -> Iterator[Opened]:
    """Open a robot on a serial port, whose other end is read."""
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    with open_serial_port(os.ttyname(theirs)) as port:

        class Wheels(voz.Robot):
            def move(self, linear: float, angular: float) -> None:
                port.write(f"{linear} {angular}\n".encode())
                lines.extend(os.read(ours, 10_000).decode().splitlines())

        lines: list[str] = []
        velocities = lambda _: [tuple(map(float, line.split())) for line in lines]  # noqa: E731
        yield [Wheels().receive], velocities
    os.close(ours)
    os.close(theirs)


@contextmanager
def simulator() -> Iterator[Opened]:
    """Open the simulated robot; what comes out is where it is, as long as that changes."""
    robot = SimulatedRobot(Simulator())
    places: list[Any] = [robot.place(0.0)]
    velocities: list[Any] = []

    def note(event: Event) -> None:
        if isinstance(event, Twist):
            places.append(robot.place(event.t))
            moved = places[-1] != places[-2]
            velocities.append((float(moved), 0.0))

    def velocities_and_after(outcome: Outcome) -> list[Any]:
        end = outcome.twists[-1].t + 1  # it brakes until then
        return [*velocities, (float(robot.place(end + 1) != robot.place(end)), 0.0)]

    yield [robot.receive, note], velocities_and_after


@contextmanager
def ros2() -> Iterator[Opened]:
    """Open a robot on ROS 2, whose topic is read by another node."""
    from voz.ros2 import Ros2Robot
    from voz.ros2 import message_types as msg
    from voz.ros2.node import Ros2Node

    reader = Ros2Node(Ros2()).reader("cmd_vel", msg.TwistMessage)
    robot = Ros2Robot(Ros2(wait=5), lambda _: None)
    robot.open()
    got: list[Any] = []

    def take(event: Event) -> None:
        robot.receive(event)
        got.extend(t for t in reader.take(100) if isinstance(t, msg.TwistMessage))

    yield [take], lambda _: [(t.linear.x, t.angular.z) for t in got]
    robot.close()


def events(kind: type[Event], value: Callable[[Any], Any]) -> Callable[[], Any]:
    """Open what gets events of a kind."""

    @contextmanager
    def opened() -> Iterator[Opened]:
        yield [], lambda outcome: [value(e) for e in outcome.events if isinstance(e, kind)]

    return opened


@contextmanager
def called() -> Iterator[Opened]:
    """Open what keeps the calls of a function."""
    waved.clear()

    def calls(_: Outcome) -> list[Any]:
        for thread in threading.enumerate():
            if thread.name == "voz-program":  # each call has one of its own
                thread.join(60)
        return waved

    yield [], calls


NO_VELOCITY = "it is no velocity: what was done is done"
NOT_MOVING = dict.fromkeys(("zero last", "zero last of an error", "limits", "loss"), NO_VELOCITY)
ALL = (
    *("obeyed", "not listening", "asleep", "late", "overtaken", "rehearsal", "reload", "confirm"),
    *("confirm declined", "limits", "loss", "zero last", "zero last of an error"),
)
ROS1 = dict.fromkeys(ALL, "rospy is Debian's: real nodes and a real master, in `tests/ros1`")

EXITS = (
    Exit("receive", in_process(Receiving)),
    Exit("move", in_process(Rolling)),
    Exit("command", in_process(Handy), "open gripper", False, NOT_MOVING),
    Exit("serial port", serial_port),
    Exit(
        "simulator",
        simulator,
        cannot={
            "limits": "what is seen of it is where it is, not how fast",
            "zero last of an error": "the run ends before it has moved",
        },
    ),
    Exit("ros1", in_process(Receiving), cannot=ROS1),
    Exit("ros2", ros2),
    Exit("publish", events(Publish, lambda e: e.value), "light on", False, NOT_MOVING),
    Exit("run", events(StartProgram, lambda e: e.program), "dance", False, NOT_MOVING),
    Exit("call", called, "wave", False, NOT_MOVING),
    Exit("say", events(Reply, lambda e: e.text), "greet", False, NOT_MOVING),
)
