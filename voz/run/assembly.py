"""How a run is put together: sources and a clock, the rules, and who receives what follows.

    microphone, keyboard, ROS ──▶ Inbox ──▶ ┐
    recordings, text, a bag  ──▶ (a Clock) ─┴▶ beat ──▶ Controller ──▶ receivers, each with a queue

Sources have threads of their own and put messages into an inbox, or tell the time themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Protocol

from msgspec.structs import replace

from voz.control.safety import zero_at_the_end
from voz.control.table import CommandTable
from voz.events import Ended, Event, Play, Receiver, Reply, Warning
from voz.inbox import End, Inbox
from voz.process.signals import let_signals_wake
from voz.run.beat import beat
from voz.run.clocks import Clock
from voz.run.controller import Controller
from voz.run.programs import Programs
from voz.run.watch import Flood, Watch, over_robots
from voz.settings import Speech
from voz.speech.speaker import Speaker


class Ears(Protocol):
    """What hears, and may stop to.

    Attributes:
        source: of its utterances.
    """

    source: str

    def trouble(self, moving: bool) -> str | None:
        """Tell why nothing is heard right now, without waiting; None if all is well.

        Args:
            moving: whether the robot moves.
        """


def run_control_loop(
    controller: Controller,
    inbox: Inbox,
    clock: Clock,
    robots: Mapping[str, Callable[[], str | None]],
    ears: Ears | None = None,
) -> None:
    """Drive by the real clock, until a message or a signal ends it; zero velocity is sent last.

    Args:
        controller: what obeys.
        inbox: where what arrives is.
        clock: takes it from there.
        robots: tells of each, by its name, why it is lost (S5).
        ears: what hears, if it is there all the time; a changed velocity is then sent at once.

    Raises:
        SystemExit: a signal came before.
    """
    watches = over_robots(controller, robots)
    if ears:
        trouble = ears.trouble
        watches.insert(
            0, Watch(controller, lambda: trouble(controller.moving), "listening again", ears.source)
        )
    looks = [*(watch.look for watch in watches), Flood(controller, inbox).look]
    with (
        zero_at_the_end(lambda: controller.zero(clock.now())),
        let_signals_wake(lambda: inbox.put(End())),
    ):
        raise_if_any(beat(controller, clock, looks, at_once=ears is not None))


@contextmanager
def speaking(
    settings: Speech, replies: Sequence[str], warn: Callable[[str], None]
) -> Iterator[Speaker | None]:
    """Who says the replies, for a `with` block; None if the robot is to be silent.

    Args:
        settings: whose voice, and whether at all.
        replies: what is said often, to be rendered beforehand.
        warn: takes what goes wrong, on any thread.
    """
    if not settings.enabled:
        yield None
        return
    with Speaker(settings.voice, replies, warn) as speaker:
        yield speaker


def replies_to(speaker: Speaker | None) -> list[Receiver]:
    """What lets a speaker say the replies and play the sounds; nothing if there is none."""

    def receive(event: Event) -> None:
        if speaker and isinstance(event, Reply):
            speaker.say(event.text)
        elif speaker and isinstance(event, Play):
            speaker.play(event.sound)

    return [receive] if speaker else []


@contextmanager
def starting(
    table: CommandTable, inbox: Inbox, clock: Clock, show: Callable[[str], None]
) -> Iterator[Receiver]:
    """What starts the programs and functions of commands, for a `with` block.

    Args:
        table: what each command does.
        inbox: where the end of each is told.
        clock: tells when that is.
        show: takes each line that a program prints, on any thread.

    Raises:
        ConfigError: there is no such program or function.
    """

    def tell(ended: Ended) -> None:
        inbox.put(replace(ended, t=clock.now()))

    with Programs(table, tell, show) as programs:
        yield programs.receive


class Warn(Protocol):
    """Takes a line for people, and whether it is good news, on any thread."""

    def __call__(self, text: str, good: bool = False) -> None:
        """Tell it."""


def warner(inbox: Inbox, clock: Clock) -> Warn:
    """What makes a Warning of a line, on any thread."""
    return lambda text, good=False: inbox.put(Warning(clock.now(), text, good))


def raise_if_any(error: Exception | None) -> None:
    """Raise what ended the beat, if it was an error."""
    if error:
        raise error
