"""The robots of a run: receivers, what a terminal shows of them, drawings after it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from voz.errors import ConfigError, RobotError
from voz.events import Event, Notice, Receiver
from voz.robot.base import Robot
from voz.robot.console import in_words
from voz.run.session import Session
from voz.terminal.live_terminal import LiveTerminal

if TYPE_CHECKING:
    from voz.robot.simulation.simulator import SimulatedRobot

CONSOLE, SIMULATOR = "console", "simulator"


@dataclass(frozen=True, kw_only=True)
class RunRobots:
    """Which robots a run has, and what is shown of them; `open` is a part of the run."""

    names: list[str]  # of the robots
    live: bool  # whether a microphone drives them; a terminal then shows what the console would say
    stream: TextIO  # where the robots print
    terminal: LiveTerminal | None = None  # the same, if it can be drawn on
    watchdog: bool = True  # whether real robots are stopped from another process, too
    picture: Path | None = None  # where the simulator's way is drawn after the run
    animation: Path | None = None  # the same, moving
    verbose: bool = False  # whether a console prints the evidence for an utterance
    info: Callable[[str], None]  # takes lines for people
    warn: Callable[[str], None]  # takes warnings

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
    def open(self, session: Session) -> Iterator[None]:
        """Open them; at the end draw what the simulated one did."""
        from voz.robot.factory import make_robots, odometry_of
        from voz.robot.kinds import RobotSetup

        clocked = session.in_real_time
        names = self._opened_names()
        with self._output_stream(clocked) as stream:
            setup = RobotSetup(
                session.spec.settings, stream, session.report, clocked and self.watchdog,
                self.verbose,
            )  # fmt: skip
            robots = make_robots(names, setup)
            session.show = setup.show
            session.controller.odometry = odometry_of(robots)
            with (
                self._drawn_room(robots, session),
                self._connected(robots, session) as receivers,
            ):
                if session.view:
                    receivers.append(session.view.receive)
                if CONSOLE not in names and not self.has_display:
                    receivers.append(partial(self._show_notice, session.language))
                session.receivers[:0] = receivers  # before files of events, which are open already
                yield

    def _opened_names(self) -> list[str]:
        """List the robots. What a live run hears is always shown: on its display, or as lines.

        So is what the simulator does, where no room can be drawn.
        """
        blind = self.terminal is None and SIMULATOR in self.names
        names = [*self.names, CONSOLE] if self.live or blind else self.names
        if self.has_display:
            names = [name for name in names if name != CONSOLE]
        # The simulator first: its warning comes before the event that caused it.
        return sorted(dict.fromkeys(names), key=lambda name: name != SIMULATOR)

    @contextmanager
    def _output_stream(self, clocked: bool) -> Iterator[TextIO]:
        """Return where lines go: above the display or the room, if one is drawn."""
        if not (self.terminal and (self.live or (clocked and SIMULATOR in self.names))):
            yield self.stream
            return
        try:
            yield self.terminal  # type: ignore[misc]
        finally:
            self.terminal.print_waiting()

    @contextmanager
    def _connected(self, robots: Mapping[str, Robot], session: Session) -> Iterator[list[Receiver]]:
        from voz.robot.factory import open_mailboxes, open_robots

        if not session.in_real_time:
            with open_robots(robots):
                yield [robot.receive for robot in robots.values()]
            return
        with open_mailboxes(robots, self.warn) as boxes:
            for name, box in boxes.items():
                session.watch(name, box.lost)
            yield [box.receive for box in boxes.values()]
        for name, box in boxes.items():
            if box.failure and not self.live:  # a live run goes on until a signal ends it
                raise RobotError(f"the robot {name} failed ({box.failure})")

    @contextmanager
    def _drawn_room(self, robots: Mapping[str, Robot], session: Session) -> Iterator[None]:
        """Draw the simulated room, if there is one, during the run or after it."""
        from voz.robot.simulation.simulator import SimulatedRobot

        simulated = robots.get(SIMULATOR)
        if not isinstance(simulated, SimulatedRobot):
            yield
            return
        from voz.robot.simulation.room_view import RoomView

        view = session.view = RoomView(simulated, session.spec.settings.simulator)
        try:
            if self.terminal and session.in_real_time and not self.live:
                with self.terminal.live(lambda: view):
                    yield
            else:
                yield
        finally:
            self._draw(simulated, session.in_real_time)

    def _draw(self, simulated: SimulatedRobot, clocked: bool) -> None:
        simulated.come_to_rest()
        trip = simulated.trip()
        if self.terminal and not clocked:
            from voz.robot.simulation.room_view import TripView

            self.terminal.console.print(TripView(trip))
        from voz.robot.simulation.pictures import save_animation, save_picture

        for path, save in ((self.picture, save_picture), (self.animation, save_animation)):
            if path:  # it takes seconds
                self.info(f"drawing {path} ...")
                save(trip, path)
                self.info(f"written: {path}, the way of the robot")

    def _show_notice(self, language: str, event: Event) -> None:
        """Show a notice where no robot of the run does."""
        if isinstance(event, Notice):
            self.info(in_words(event, language))
