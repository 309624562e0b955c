"""Makes robots by their names, opens them, and lets go of them."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any

from voz.errors import ConfigError, RobotError
from voz.robot.base import Robot
from voz.robot.kinds import ROBOTS, RobotSetup
from voz.robot.mailbox import Mailbox
from voz.robot.robot_process import RobotProcess, RobotSpec
from voz.robot.slow import SlowRobot
from voz.robot.user_code import imported
from voz.robot.user_errors import mistakes_told


def have_a_clock(names: Sequence[str]) -> bool:
    """Whether robots of these names have a real clock, so that a run with them must have one."""
    return any(name not in ROBOTS or ROBOTS[name].has_a_clock for name in names)


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


def make_robots(names: Sequence[str], setup: RobotSetup) -> dict[str, Robot]:
    """Make robots by their names.

    Args:
        names: of `ROBOTS`, or MODULE:CLASS for a class of the user's own.
        setup: what they are made from.

    Returns:
        The robots, by their names. With a watchdog, one of the user's own is in its process, and
        one that others can drive too has another robot beside it, which can only stop it.

    Raises:
        RobotError: a robot's module cannot be imported, or the robot not be made.
    """
    robots: dict[str, Robot] = {}
    for name in names:
        with mistakes_told(name):
            if name not in ROBOTS:
                own = setup.settings.own
                robots[name] = _apart(setup, name) if setup.watchdog else make_own(name, own)
                continue
            kind = ROBOTS[name]
            robots[name] = kind.make(setup)
            if setup.watchdog and kind.make_watchdog:
                robots[f"{name} watchdog"] = _apart(setup, name, only_zero=True)
    simulator: Any = robots.get(
        "simulator"
    )  # of its class, which is imported only where it is made
    if simulator:
        for name in robots.keys() - {"simulator"}:
            robots[name].where = simulator.state_at  # RViz shows it then
    return robots


def make_apart(order: RobotSpec) -> Robot:
    """Make, in its process, a robot of the user's own, or what can only stop another one."""
    kind = ROBOTS.get(order.name)
    if kind and kind.make_watchdog:
        return kind.make_watchdog(order)
    return make_own(order.name, order.settings.own)


def make_own(name: str, settings: Mapping[str, Mapping[str, Any]]) -> Robot:
    """Make a robot of the user's own.

    Args:
        name: MODULE:CLASS.
        settings: those of the user's own robots, by their modules; they are the class's arguments.

    Raises:
        ConfigError: the class does not take them.
        RobotError: it is no robot.
    """
    make = imported(name)
    module = name.partition(":")[0]
    arguments = settings.get(module, {})
    if arguments:
        _check_arguments(make, arguments, f"[own.{module}] in voz.toml")
    robot = make(**arguments)
    for needed in ("open", "receive", "lost", "close"):
        if not callable(getattr(robot, needed, None)):
            raise RobotError(
                f"the robot {name} has no {needed}(); derive its class from voz.robot.base.Robot"
            )
    return SlowRobot(robot) if getattr(robot, "slow", False) else robot


def _check_arguments(make: type[Robot], arguments: Mapping[str, Any], place: str) -> None:
    """Refuse settings that a class does not take; raises ConfigError, which names their place."""
    try:
        inspect.signature(make).bind(**arguments)
    except TypeError as error:
        raise ConfigError(
            f"{place} does not fit the class {make.__name__} ({error}): correct one of them"
        ) from None


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
            for box in boxes.values():  # all before any is waited for: to leave ROS takes a second
                stack.callback(box.finish)
            yield boxes
    finally:
        for name, box in boxes.items():
            if box.hangs:
                tell(f"the robot {name} did not take its last velocity in time")


def _apart(setup: RobotSetup, name: str, only_zero: bool = False) -> RobotProcess:
    """A robot in a process of its own, which prints where the others do."""
    spec = RobotSpec(name, setup.settings, only_zero, path=tuple(sys.path))
    return RobotProcess(spec, setup.show)
