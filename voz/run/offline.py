"""A run by recordings, a text or a bag: as fast as it can be understood, or at its own pace."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from typing import Protocol, TypeAlias

from voz.config import Config
from voz.control.bound import Place
from voz.control.safety import zero_at_the_end
from voz.events import Receiver, Warning
from voz.inbox import Inbox
from voz.run.assembly import raise_if_any, replies_to, run_control_loop, speaking, starting, warner
from voz.run.beat import beat
from voz.run.clocks import Item, PacedClock, RecordedClock
from voz.run.controller import Controller
from voz.run.paced import pace
from voz.run.programs import Programs

Played: TypeAlias = Callable[[Callable[[], float]], Iterator[Item]]
"""What drives the robot, made from what tells the time of the run, s."""

Tell: TypeAlias = Callable[[Warning], None]


class OpenRobots(Protocol):
    """Who receives the events, and what tells of each robot, by its name, why it is lost."""

    @property
    def receivers(self) -> list[Receiver]:
        """Called with every event, in order."""

    @property
    def troubles(self) -> Mapping[str, Callable[[], str | None]]:
        """Tells of each robot, by its name, why it is lost."""

    @property
    def odometry(self) -> Callable[[float], Place | None]:
        """Tells where the robot is at a time of the run, s, without waiting."""

    @property
    def show(self) -> Callable[[str], None]:
        """Prints a line where the robots print, on any thread."""


Opened: TypeAlias = Callable[[Tell], AbstractContextManager[OpenRobots]]
"""Opens the robots for a `with` block, given what takes their warnings."""


def run_at_once(played: Played, settings: Config, listening: bool, opened: Opened) -> None:
    """Drive with no clock but that of what is played: the same events each time.

    Args:
        played: what drives the robot.
        settings: the safety rules and the voice.
        listening: whether commands are obeyed before a `start speech`.
        opened: opens the robots.
    """
    problems: list[str] = []
    table = settings.table
    with opened(lambda told: controller.emit(told)) as robots:
        clock = RecordedClock(played(lambda: 0.0))
        with (
            speaking(settings.speech, table.replies, problems.append) as speaker,
            Programs(
                table, lambda ended: controller.emit(ended), robots.show, wait=True
            ) as programs,
        ):
            receivers = [*robots.receivers, *replies_to(speaker), programs.receive]
            controller = Controller(receivers, settings.safety, listening, table, robots.odometry)
            with zero_at_the_end(lambda: controller.zero(clock.now())):
                raise_if_any(beat(controller, clock))
                if speaker:
                    # Only now: when a thread meets a problem hangs on the machine, events must not.
                    speaker.close()
                    for problem in problems:
                        controller.emit(Warning(clock.now(), problem))


def run_at_its_pace(played: Played, settings: Config, listening: bool, opened: Opened) -> None:
    """Drive by the clock, for robots whose time is the real one; the arguments are the same."""
    table = settings.table
    inbox = Inbox(table.halts)
    with opened(inbox.put) as robots:
        clock = PacedClock(inbox)
        warn = warner(inbox, clock)
        with (
            speaking(settings.speech, table.replies, warn) as speaker,
            starting(table, inbox, clock, robots.show) as start,
        ):
            receivers = [*robots.receivers, *replies_to(speaker), start]
            controller = Controller(receivers, settings.safety, listening, table, robots.odometry)
            pace(played(clock.exactly), inbox, clock)
            run_control_loop(controller, inbox, clock, robots.troubles)
