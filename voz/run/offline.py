"""A run by recordings, a text or a bag: as fast as possible, or at their own pace."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import TypeAlias

from voz.config import Config
from voz.events import Notice
from voz.inbox import Inbox
from voz.run.clocks import Item, PacedClock, RecordedClock
from voz.run.paced import pace
from voz.run.programs import Programs
from voz.run.session import (
    OpenRobots,
    Session,
    new_session,
    open_programs,
    open_speaker,
    speech_receivers,
    warner,
)
from voz.speech.reply_speaker import ReplySpeaker

Source: TypeAlias = Callable[[Callable[[], float]], Iterator[Item]]
"""What drives the robot, made from what returns the time of the run, s."""

RobotOpener: TypeAlias = Callable[[Callable[[Notice], None]], AbstractContextManager[OpenRobots]]
"""Opens the robots for a `with` block, given what takes their warnings."""


def run_unpaced(
    source: Source, settings: Config, listening: bool, open_robots: RobotOpener
) -> None:
    """Drive with no clock but that of the source: the same events each time.

    Args:
        source: what drives the robot.
        settings: the safety rules and the voice.
        listening: whether commands are obeyed before a `start speech`.
        open_robots: opens the robots.
    """
    problems: list[str] = []
    session = new_session(settings, RecordedClock(source(lambda: 0.0)), listening)
    table = session.table
    with (
        open_robots(session.controller.emit) as robots,
        open_speaker(settings.speech, table.replies, problems.append) as speaker,
        Programs(table, session.controller.emit, robots.show, wait=True) as programs,
    ):
        session.add_robots(robots)
        session.receivers += [*speech_receivers(speaker), programs.receive]
        session.run(finish=lambda: _warn_of(problems, speaker, session))


def run_paced(source: Source, settings: Config, listening: bool, open_robots: RobotOpener) -> None:
    """Drive by the real clock, for robots that need it; arguments as for `run_unpaced`."""
    table = settings.table
    inbox = Inbox(table.halts)
    with open_robots(inbox.put) as robots:
        clock = PacedClock(inbox)
        session = new_session(settings, clock, listening)
        with (
            open_speaker(settings.speech, table.replies, warner(inbox, clock)) as speaker,
            open_programs(table, inbox, clock, robots.show) as programs,
        ):
            session.add_robots(robots)
            session.receivers += [*speech_receivers(speaker), programs.receive]
            pace(source(clock.exactly), inbox, clock)
            session.run_in_real_time(inbox)


def _warn_of(problems: list[str], speaker: ReplySpeaker | None, session: Session) -> None:
    """Report what could not be said at the end only: the speaker's threads are not on time."""
    if speaker:
        speaker.close()
    for problem in problems:
        session.controller.emit(Notice(session.clock.now(), problem))
