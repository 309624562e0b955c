"""The robots of a run: receivers, what a terminal shows of them, drawings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TextIO, TypeAlias

from voz.cli.text_io import info, warn
from voz.errors import ConfigError, RobotError
from voz.events import Event, Notice, Receiver

if TYPE_CHECKING:
    from voz.config import Config
    from voz.robot.base import Robot
    from voz.robot.simulation.room_view import RoomView
    from voz.robot.simulation.simulator import SimulatedRobot
    from voz.run.session import OpenRobots
    from voz.terminal.live_terminal import LiveTerminal

Troubles: TypeAlias = dict[str, Callable[[], str | None]]

CONSOLE, SIMULATOR = "console", "simulator"


@dataclass(frozen=True)
class RobotPlan:
    """Which robots a run has, and what is shown of them.

    Attributes:
        names: of the robots.
        live: whether a microphone drives them; a terminal then shows what the console would say.
        clocked: whether the run has a real clock, and each robot a thread.
        watchdog: whether real robots are stopped from another process, too.
        stream: where the robots print.
        terminal: the same, if it can be drawn on.
        picture: where the simulator's way is drawn after the run.
        animation: the same, moving.
        verbose: whether a console prints the evidence for an utterance.
    """

    names: list[str]
    live: bool
    clocked: bool
    watchdog: bool
    stream: TextIO
    terminal: LiveTerminal | None
    picture: Path | None = None
    animation: Path | None = None
    verbose: bool = False

    @property
    def has_display(self) -> bool:
        """Whether a terminal shows what is heard."""
        return self.live and self.terminal is not None

    def check(self) -> None:
        """Refuse, before the run, what cannot be drawn after it."""
        from voz.robot.simulation.pictures import check_animation, check_picture

        for path, check in ((self.picture, check_picture), (self.animation, check_animation)):
            if path and SIMULATOR not in self.names:
                raise ConfigError(f"{path}: shows the simulator; add --robot simulator")
            if path:
                check(path)


@contextmanager
def open_robots(
    plan: RobotPlan, settings: Config, take: Callable[[Notice], None]
) -> Iterator[OpenRobots]:
    """Open the robots for a `with` block; at its end draw what the simulated one did.

    Their warnings go to `take`.
    """
    from voz.robot.factory import make_robots, odometry_of
    from voz.robot.kinds import RobotSetup
    from voz.run.session import OpenRobots

    names = _robot_names(plan)
    with ExitStack() as stack:
        stream = stack.enter_context(_output_stream(plan))
        watchdog = plan.clocked and plan.watchdog
        setup = RobotSetup(settings, stream, take, watchdog, plan.verbose)
        robots = make_robots(names, setup)
        view = stack.enter_context(_drawn_room(robots, plan, settings))
        receivers, troubles = stack.enter_context(_opened_robots(robots, plan))
        if view:
            receivers.append(view.receive)
        if CONSOLE not in names and not plan.has_display:
            receivers.append(_show_warning)
        yield OpenRobots(receivers, troubles, odometry_of(robots), setup.show, view)


def _robot_names(plan: RobotPlan) -> list[str]:
    """List the robots. What a live run hears is always shown: on its display, or as lines."""
    names = [*plan.names, CONSOLE] if plan.live else plan.names
    if plan.has_display:
        names = [name for name in names if name != CONSOLE]
    # The simulator first: its warning comes before the event that caused it.
    return sorted(dict.fromkeys(names), key=lambda name: name != SIMULATOR)


@contextmanager
def _output_stream(plan: RobotPlan) -> Iterator[TextIO]:
    """Return where lines go: above the display or the room, if one is drawn."""
    if not (plan.terminal and (plan.live or (plan.clocked and SIMULATOR in plan.names))):
        yield plan.stream
        return
    try:
        yield plan.terminal  # type: ignore[misc]
    finally:
        plan.terminal.print_waiting()


@contextmanager
def _opened_robots(
    robots: Mapping[str, Robot], plan: RobotPlan
) -> Iterator[tuple[list[Receiver], Troubles]]:
    from voz.robot.factory import open_mailboxes, open_robots

    if plan.clocked:
        with open_mailboxes(robots, warn) as boxes:
            receivers: list[Receiver] = [box.receive for box in boxes.values()]
            yield receivers, {name: box.lost for name, box in boxes.items()}
        for name, box in boxes.items():
            if box.failure and not plan.live:  # a live run goes on until a signal ends it
                raise RobotError(f"the robot {name} failed ({box.failure})")
    else:
        with open_robots(robots):
            yield [robot.receive for robot in robots.values()], {}


@contextmanager
def _drawn_room(
    robots: Mapping[str, Robot], plan: RobotPlan, settings: Config
) -> Iterator[RoomView | None]:
    """Draw the simulated room, if there is one, during the run or after it."""
    from voz.robot.simulation.simulator import SimulatedRobot

    simulated = robots.get(SIMULATOR)
    if not isinstance(simulated, SimulatedRobot):
        yield None
        return
    from voz.robot.simulation.room_view import RoomView

    view = RoomView(simulated, settings.simulator)
    try:
        if plan.terminal and plan.clocked and not plan.live:
            with plan.terminal.live(lambda: view):
                yield view
        else:
            yield view
    finally:
        _draw(simulated, plan)


def _draw(simulated: SimulatedRobot, plan: RobotPlan) -> None:
    simulated.come_to_rest()
    trip = simulated.trip()
    if plan.terminal and not plan.clocked:
        from voz.robot.simulation.room_view import TripView

        plan.terminal.console.print(TripView(trip))
    from voz.robot.simulation.pictures import save_animation, save_picture

    for path, save in ((plan.picture, save_picture), (plan.animation, save_animation)):
        if path:  # it takes seconds
            info(f"drawing {path} ...")
            save(trip, path)
            info(f"written: {path}, the way of the robot")


def _show_warning(event: Event) -> None:
    """Show warnings where no robot of the run does."""
    if isinstance(event, Notice):
        (info if event.good else warn)(event.text)
