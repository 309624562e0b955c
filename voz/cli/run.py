"""`voz run`: drives a robot."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, NoReturn, TextIO, TypeAlias

import typer

from voz.cli.exit_codes import SOME_UNREADABLE
from voz.cli.options import with_options
from voz.cli.robots import Plan, Robots, robots_of
from voz.cli.run_options import Running
from voz.cli.terminal import open_text, warn

if TYPE_CHECKING:
    from rich.console import Console

    from voz.config import Config, Ros2
    from voz.events import Receiver, Warning
    from voz.language.files import LanguageFiles
    from voz.live.messages import Inbox
    from voz.live.session import Typist
    from voz.pipeline import Pipeline
    from voz.recognition.profiles import Profile
    from voz.recognition.recognizer import Recognizer


Obey: TypeAlias = "Callable[[Pipeline], list[str] | None]"
"""Drives by what is not live; gives what of it could not be read."""


@with_options
def run(options: Running) -> None:
    """Drive a robot by your voice, or by recordings or typed commands.

    With a microphone, space stops the robot at once and commands may be typed too. In a text,
    `-` alone on a line lets a cycle of 0.1 s pass with no command.

    Example: voz run --wav audio_fixtures/long/session.wav --robot console,simulator
    """
    from voz.live.quiet import quiet_libraries

    options.check()
    settings = options.settings()
    with ExitStack() as parts:
        parts.enter_context(quiet_libraries())
        plan = _plan(options, settings)
        language = options.language(settings)
        if options.live:
            _run_live(options, settings, plan, language, parts)
        unreadable = _run_by_files(options, settings, plan, language, parts)
    if unreadable:
        raise typer.Exit(SOME_UNREADABLE)


def _plan(options: Running, settings: Config) -> Plan:
    """Which robots there are; refuses, before the run, what cannot be written after it."""
    from voz.bags import check_bag
    from voz.robot.robots import have_a_clock, robot_names

    names = robot_names(settings.robot)
    clocked = options.live or options.realtime or have_a_clock(names)
    stream = sys.stderr if options.events == "-" else sys.stdout
    seen = _terminal(stream), options.picture, options.animation
    plan = Plan(names, options.live, clocked, stream, *seen)
    plan.check()
    if options.bag:
        check_bag(options.bag)
    return plan


def _run_live(
    options: Running, settings: Config, plan: Plan, language: LanguageFiles, parts: ExitStack
) -> NoReturn:
    """Drive by the microphone until a signal ends the program."""
    from voz.audio.devices import choose
    from voz.language.files import read_sentences
    from voz.live.session import run_live

    microphone = choose(options.device).name
    recognizer = parts.enter_context(_recognizer(options, settings, language, microphone))
    inbox: Inbox = SimpleQueue()
    robots = parts.enter_context(_receivers(options, settings, plan, inbox.put))
    run_live(
        robots.receivers,
        settings,
        recognizer,
        read_sentences(language),
        inbox,
        device=options.device,
        listening=options.listening,
        terminal=plan.terminal,
        record=options.record,
        lost=robots.lost,
        extra=robots.view,
        also=_other_recogniser(settings.ros2) if options.listen_ros else None,
    )


def _run_by_files(
    options: Running, settings: Config, plan: Plan, language: LanguageFiles, parts: ExitStack
) -> list[str] | None:
    """Drive by recordings, a text or a bag; gives the recordings that could not be read."""
    from voz.pipeline import Pipeline, running

    obey = _obey(options, settings, language, parts)
    inbox: Inbox = SimpleQueue()
    take: Callable[[Warning], None] = inbox.put if plan.clocked else lambda w: drive.emit(w)
    robots = parts.enter_context(_receivers(options, settings, plan, take))
    voice = settings.speech.voice if settings.speech.enabled else None
    kind = _by_the_clock(robots.lost, inbox) if plan.clocked else Pipeline
    with running(robots.receivers, settings.safety, voice, options.listening, kind) as drive:
        return obey(drive)


def _obey(options: Running, settings: Config, language: LanguageFiles, parts: ExitStack) -> Obey:
    """Open what drives the robot, before anything moves."""
    from voz import pipeline
    from voz.language.files import read_sentences

    if options.text:
        lines = open_text(options.text, parts)
        return partial(pipeline.drive_by_text, lines=lines, commands=read_sentences(language))
    if options.replay:
        from voz.bags import read_sayings

        return partial(
            pipeline.drive_by_bag,
            path=options.replay,
            sayings=read_sayings(options.replay),
            commands=read_sentences(language),
        )
    recognizer = parts.enter_context(_recognizer(options, settings, language, "recordings"))
    return partial(pipeline.drive_by_recordings, paths=options.recordings, recognizer=recognizer)


@contextmanager
def _receivers(
    options: Running, settings: Config, plan: Plan, take: Callable[[Warning], None]
) -> Iterator[Robots]:
    """Open the robots, and what else gets the events; by the clock they do not wait for that."""
    from voz.aside import Aside
    from voz.bags import bag_of
    from voz.cli.event_log import event_log

    def written(name: str, opening: AbstractContextManager[Receiver]) -> Receiver:
        return parts.enter_context(Aside(name, opening, take) if plan.clocked else opening)

    with ExitStack() as parts:
        log = [written(options.events, event_log(options.events))] if options.events else []
        robots = parts.enter_context(robots_of(plan, settings, take))
        bag = [written(str(options.bag), bag_of(options.bag))] if options.bag else []
        yield robots._replace(receivers=[*robots.receivers, *log, *bag])


def _by_the_clock(
    lost: Mapping[str, Callable[[], str | None]], inbox: Inbox
) -> Callable[..., Pipeline]:
    from voz.realtime import RealtimePipeline

    return partial(RealtimePipeline, lost=lost, inbox=inbox)


def _other_recogniser(settings: Ros2) -> Callable[[Typist], AbstractContextManager[None]]:
    """What lets the commands that another recogniser publishes on ROS 2 be obeyed."""
    from voz.robot.ros2 import HEARD_ON_ROS, heard_on_ros

    return lambda typist: heard_on_ros(settings, lambda text: typist(text, HEARD_ON_ROS))


def _terminal(stream: TextIO) -> Console | None:
    """The terminal to draw on, if there is one to be seen."""
    if not stream.isatty():
        return None
    from rich.console import Console

    return Console(file=stream)


@contextmanager
def _recognizer(
    options: Running, settings: Config, language: LanguageFiles, place: str
) -> Iterator[Recognizer]:
    """Load the recogniser; if it adapts, what it learns at this place is kept for later runs."""
    from voz.recognition.profiles import USUAL_PROFILE, learnt_file, load_profile, save_learnt
    from voz.recognition.recognizer import Recognizer

    known = load_profile(options.profile) if options.profile else None
    if not options.adapt:
        yield Recognizer(language, settings.recognition, known)
        return
    learnt = learnt_file(options.profile or USUAL_PROFILE, place)
    known = _with_learnt(known, learnt)
    recognizer = Recognizer(language, settings.recognition, known, learning=True)
    try:
        yield recognizer
    finally:
        warn(save_learnt(learnt, recognizer.learnt))


def _with_learnt(known: Profile | None, path: Path) -> Profile:
    """Put what was learnt in earlier runs in place of what the profile starts from."""
    from msgspec.structs import replace

    from voz.recognition.profiles import Profile, load_learnt

    learnt, problem = load_learnt(path)
    warn(problem)
    known = known or Profile()
    return replace(known, start=learnt) if learnt.frames else known
