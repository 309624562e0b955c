"""Which robots there are, by the names that `voz run --robot` takes, and how each is made.

What a robot needs is imported only when it is made: the help of the command line reads the names.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, TextIO

from voz.config import Config
from voz.events import Notice
from voz.robot.base import Robot

if TYPE_CHECKING:
    from voz.robot.robot_process import RobotSpec


@dataclass(frozen=True)
class RobotSetup:
    """What robots are made from."""

    settings: Config  # with a table for each robot
    stream: TextIO  # where robots print
    warn: Callable[[Notice], None]  # called with the robots' warnings, on any thread
    # Whether real robots get a watchdog process, which stops them if this one cannot.
    watchdog: bool = False
    verbose: bool = False  # whether the console prints the evidence for an utterance

    def show(self, line: str) -> None:
        """Print a line where the robots print, on any thread."""
        with suppress(OSError, ValueError):  # nobody reads it any more
            self.stream.write(f"{line}\n")


@dataclass(frozen=True)
class RobotKind:
    """A robot of voz's own; one that cannot run away has no watchdog.

    `does` says what it does with the commands, for the help of the command line.
    """

    does: str
    make: Callable[[RobotSetup], Robot]
    make_watchdog: Callable[[RobotSpec], Robot] | None = None

    @property
    def needs_real_time(self) -> bool:
        """Whether it is a real robot; others take events as fast as they come."""
        return self.make_watchdog is not None


def _console(setup: RobotSetup) -> Robot:
    from voz.robot.console import ConsoleRobot
    from voz.texts import language_of

    language = language_of(setup.settings.language.name)
    return ConsoleRobot(setup.stream, setup.verbose, language)


def _simulator(setup: RobotSetup) -> Robot:
    from voz.robot.simulation.simulator import SimulatedRobot

    return SimulatedRobot(setup.settings.simulator, setup.warn)


def _ros1(setup: RobotSetup) -> Robot:
    from voz.ros1.robot import Ros1Robot

    return Ros1Robot(setup.settings.ros1, table=setup.settings.table, warn=setup.warn)


def _ros1_watchdog(spec: RobotSpec) -> Robot:
    from voz.ros1.robot import Ros1Watchdog

    return Ros1Watchdog(spec)


def _ros2(setup: RobotSetup) -> Robot:
    from voz.ros2 import Ros2Robot

    return Ros2Robot(setup.settings.ros2, setup.warn, setup.settings.table)


def _ros2_watchdog(spec: RobotSpec) -> Robot:
    from voz.ros2.base_topics import Ros2Watchdog

    return Ros2Watchdog(spec)


ROBOTS: Mapping[str, RobotKind] = {
    "console": RobotKind("says them in words; this is what you get if you name none", _console),
    "simulator": RobotKind(
        "drives through a room with a table, a beer and a cocacola, and points an arm at them",
        _simulator,
    ),
    "ros1": RobotKind(
        "publishes them for ROS 1, with `odom` and `tf` of a simulator beside it; in `.venv-ros1`",
        _ros1,
        _ros1_watchdog,
    ),
    "ros2": RobotKind(
        "publishes them for ROS 2, with `odom` and `tf` of a simulator beside it",
        _ros2,
        _ros2_watchdog,
    ),
}
