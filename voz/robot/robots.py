"""Which robots there are, by the names that `voz run --robot` takes."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from importlib import import_module, invalidate_caches
from pathlib import Path
from typing import Any, NamedTuple, TextIO

from msgspec.structs import replace

from voz.config import Config
from voz.errors import ConfigError, RobotError
from voz.events import Warning
from voz.robot.base import Robot
from voz.robot.mailbox import Mailbox
from voz.robot.mistakes import mistakes_told
from voz.robot.process import Order, RobotProcess
from voz.robot.slow import SlowRobot


class Setup(NamedTuple):
    """What robots are made from.

    Attributes:
        settings: each robot has its own table there.
        stream: where one that prints prints to.
        warn: takes the warnings of one that has some, on any thread.
        watchdog: whether the robots that are really there get a process besides this one, which
            stops them if this one cannot.
        verbose: whether one that prints tells what each ear made of an utterance.
    """

    settings: Config
    stream: TextIO
    warn: Callable[[Warning], None]
    watchdog: bool = False
    verbose: bool = False


def _console(setup: Setup) -> Robot:
    from voz.robot.console import ConsoleRobot

    return ConsoleRobot(setup.stream, setup.verbose)


def _simulator(setup: Setup) -> Robot:
    from voz.robot.simulator import SimulatedRobot

    return SimulatedRobot(setup.settings.simulator, setup.warn)


def _ros(name: str, *others: str) -> Callable[[Setup], Robot]:
    """A robot in a module of its name, made from the settings in the table of its name.

    Args:
        name: of the robot.
        others: what else of the setup it is made from.
    """

    def load(setup: Setup) -> Robot:
        kind = _imported(f"voz.robot.{name}", f"{name.capitalize()}Robot")
        more = (getattr(setup, other) for other in others)
        return kind(getattr(setup.settings, name), *more)

    return load


ROBOTS: Mapping[str, Callable[[Setup], Robot]] = {
    "console": _console,
    "simulator": _simulator,
    "ros1": _ros("ros1"),
    "ros2": _ros("ros2", "warn"),
}
"""What makes each robot; what it needs is imported only then."""

WATCHDOGS: Mapping[str, tuple[str, str]] = {
    "ros1": ("voz.robot.ros1", "Ros1Watchdog"),
    "ros2": ("voz.robot.ros2.velocity", "Ros2Watchdog"),
}
"""Module and class of what stops these robots from another process; made from an `Order`."""

IN_ANY_TIME = ("console", "simulator")
"""They take the events as fast as a recording gives them; any other robot has a real clock."""


def have_a_clock(names: Sequence[str]) -> bool:
    """Whether robots of these names have a real clock, so that a run with them must have one."""
    return not set(names) <= set(IN_ANY_TIME)


def robot_names(wanted: Sequence[str]) -> list[str]:
    """Find out which robots are wanted.

    Args:
        wanted: names as they are in voz.toml or were given as options, some with commas between.

    Returns:
        Each once, in that order.

    Raises:
        ConfigError: there is no robot of that name.
    """
    names = [name.strip() for text in wanted for name in text.split(",") if name.strip()]
    for name in names:
        if name not in ROBOTS and ":" not in name:
            known = ", ".join(ROBOTS)
            raise ConfigError(
                f"there is no robot {name}; name one of {known}, or your own as MODULE:CLASS"
            )
    return list(dict.fromkeys(names))


def make_robots(names: Sequence[str], setup: Setup) -> dict[str, Robot]:
    """Make robots by their names.

    Args:
        names: of `ROBOTS`, or MODULE:CLASS for a class of the user's own that takes no arguments.
        setup: what they are made from.

    Returns:
        The robots, by their names. With a watchdog, one of the user's own is in its process, and
        one that others can drive too has another robot beside it, which can only stop it.

    Raises:
        RobotError: a robot's module cannot be imported, or the robot not be made.
    """
    robots: dict[str, Any] = {}
    for name in names:
        with mistakes_told(name):
            if name not in ROBOTS:
                robots[name] = _apart(setup, Order(name)) if setup.watchdog else make_own(name)
                continue
            robots[name] = ROBOTS[name](setup)
            if setup.watchdog and name in WATCHDOGS:
                robots[f"{name} watchdog"] = _apart(setup, Order(name, only_zero=True))
    if "simulator" in robots:
        for name in robots.keys() & {"ros1", "ros2"}:
            robots[name].where = robots["simulator"].state_at  # RViz shows it then
    return robots


def make_watchdog(order: Order) -> Robot:
    """Make, in its own process, what can only stop a robot that another process drives."""
    module, kind = WATCHDOGS[order.name]
    return _imported(module, kind)(order)


def make_own(name: str) -> Robot:
    """Make a robot of the user's own, from its name MODULE:CLASS."""
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)  # a module beside voz.toml, as `python` itself would find it
    invalidate_caches()  # it may have been written since
    robot = _imported(*name.split(":", 1))()
    for needed in ("open", "receive", "lost", "close"):
        if not callable(getattr(robot, needed, None)):
            raise RobotError(
                f"the robot {name} has no {needed}(); derive its class from voz.robot.base.Robot"
            )
    return SlowRobot(robot) if getattr(robot, "slow", False) else robot


@contextmanager
def opened(robots: Mapping[str, Robot]) -> Iterator[None]:
    """Open robots and close them at the end of a `with` block, for events without a clock."""
    with ExitStack() as stack:
        for name, robot in robots.items():
            with mistakes_told(name):
                robot.open()
            stack.callback(robot.close)
        yield


@contextmanager
def mailboxes(
    robots: Mapping[str, Robot], tell: Callable[[str], None]
) -> Iterator[dict[str, Mailbox]]:
    """Open robots for a `with` block, each with a mailbox; all take the last event before it ends.

    Args:
        robots: by their names.
        tell: takes a line about a robot that did not.

    Raises:
        RobotError: one cannot be reached.
    """
    boxes = {name: Mailbox(name, robot) for name, robot in robots.items()}
    try:
        with ExitStack() as stack:
            for name, box in boxes.items():
                robot = robots[name]
                if isinstance(robot, RobotProcess):
                    stack.callback(robot.end)
                stack.enter_context(box)
            yield boxes
    finally:
        for name, box in boxes.items():
            if box.hangs:
                tell(f"the robot {name} did not take its last velocity in time")


def _apart(setup: Setup, order: Order) -> RobotProcess:
    """A robot in a process of its own, which prints where the others do."""

    def show(line: str) -> None:
        with suppress(OSError, ValueError):  # nobody reads it any more
            setup.stream.write(f"{line}\n")

    return RobotProcess(replace(order, settings=setup.settings, path=tuple(sys.path)), show)


def _imported(module: str, kind: str) -> Callable[..., Robot]:
    found: Callable[..., Robot] = getattr(import_module(module), kind)
    return found
