"""Makes, opens and closes robots by their names."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any

from voz.control.motion import Place
from voz.errors import ConfigError, RobotError
from voz.robot.base import Robot, check_receives
from voz.robot.kinds import ROBOTS, RobotSetup
from voz.robot.mailbox import Mailbox, SlowRobot
from voz.robot.robot_process import RobotProcess, RobotSpec
from voz.robot.user_code import import_target, user_errors_as_mistake


def need_real_time(names: Sequence[str]) -> bool:
    """Whether robots of these names need a run in real time."""
    return any(name not in ROBOTS or ROBOTS[name].needs_real_time for name in names)


def robot_names(wanted: Sequence[str]) -> list[str]:
    """Split names, of settings or options, at commas; each once, in order.

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
    """Make robots by their names: of `ROBOTS`, or MODULE:CLASS for a user's own class.

    Returns:
        The robots, by their names. With a watchdog, a user's robot is in its own process, and a
        real one has a watchdog as another robot.

    Raises:
        RobotError: a robot cannot be imported or made.
    """
    robots: dict[str, Robot] = {}
    for name in names:
        with user_errors_as_mistake(name):
            if name not in ROBOTS:
                own = setup.settings.own
                robots[name] = (
                    _in_own_process(setup, name) if setup.watchdog else make_user_robot(name, own)
                )
                continue
            kind = ROBOTS[name]
            robots[name] = kind.make(setup)
            if setup.watchdog and kind.make_watchdog:
                robots[f"{name} watchdog"] = _in_own_process(setup, name, only_zero=True)
    simulator: Any = robots.get("simulator")  # its class is imported only where it is made
    if simulator:
        for name in robots.keys() - {"simulator"}:
            robots[name].where = simulator.state_at  # RViz shows it then
    return robots


def make_in_process(spec: RobotSpec) -> Robot:
    """Make a user's robot or a watchdog; called in its own process."""
    kind = ROBOTS.get(spec.name)
    if kind and kind.make_watchdog:
        return kind.make_watchdog(spec)
    return make_user_robot(spec.name, spec.settings.own)


def make_user_robot(name: str, settings: Mapping[str, Mapping[str, Any]]) -> Robot:
    """Make a user's robot, named MODULE:CLASS, with `settings[MODULE]` as its arguments."""
    make = import_target(name)
    module = name.partition(":")[0]
    arguments = settings.get(module, {})
    if arguments:
        _check_arguments(make, arguments, f"[own.{module}] in voz.toml")
    robot = make(**arguments)
    if isinstance(robot, Robot):
        check_receives(robot)
    for needed in ("open", "receive", "lost", "close"):
        if not callable(getattr(robot, needed, None)):
            raise RobotError(
                f"the robot {name} has no {needed}(); derive its class from voz.robot.base.Robot"
            )
    return SlowRobot(robot) if getattr(robot, "slow", False) else robot


def _check_arguments(make: type[Robot], arguments: Mapping[str, Any], place: str) -> None:
    try:
        inspect.signature(make).bind(**arguments)
    except TypeError as error:
        raise ConfigError(
            f"{place} does not fit the class {make.__name__} ({error}): correct one of them"
        ) from None


@contextmanager
def open_robots(robots: Mapping[str, Robot]) -> Iterator[None]:
    """Open robots for a `with` block, in a run that is not in real time."""
    with ExitStack() as stack:
        for name, robot in robots.items():
            with user_errors_as_mistake(name):
                robot.open()
            stack.callback(robot.close)
        yield


@contextmanager
def open_mailboxes(
    robots: Mapping[str, Robot], tell: Callable[[str], None]
) -> Iterator[dict[str, Mailbox]]:
    """Open robots in a `with` block, each with a mailbox; its end waits for their last events.

    Calls `tell` with a line for a robot that does not take them. Raises RobotError.
    """
    boxes = {name: Mailbox(name, robot) for name, robot in robots.items()}
    try:
        with ExitStack() as stack:
            for name, box in boxes.items():
                robot = robots[name]
                if isinstance(robot, RobotProcess):
                    stack.callback(robot.end)
                stack.enter_context(box)
            for box in boxes.values():  # all before waiting for one: leaving ROS takes a second
                stack.callback(box.finish)
            yield boxes
    finally:
        for name, box in boxes.items():
            if box.hangs:
                tell(f"the robot {name} did not take its last velocity in time")


def odometry_of(robots: Mapping[str, Robot]) -> Callable[[float], Place | None]:
    """Return what gives the place at a time of the run, s, from the first robot that knows it.

    It raises RobotMistake for an error of a user's own robot.
    """

    def place(t: float) -> Place | None:
        for name, robot in robots.items():
            with user_errors_as_mistake(name):
                if known := robot.place(t):
                    x, y, heading = map(float, known)
                    return x, y, heading
        return None

    return place


def _in_own_process(setup: RobotSetup, name: str, only_zero: bool = False) -> RobotProcess:
    spec = RobotSpec(name, setup.settings, only_zero, path=tuple(sys.path))
    return RobotProcess(spec, setup.show)
