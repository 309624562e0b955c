"""`voz run`: drives a robot."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import IO, TYPE_CHECKING, Annotated, TextIO, TypeAlias

import typer

from voz.cli.exit_codes import SOME_UNREADABLE
from voz.cli.options import DeviceOption, ProfileOption, Recognising, with_options
from voz.cli.robots import Plan, robots_of
from voz.cli.terminal import open_text, warn
from voz.errors import ConfigError

if TYPE_CHECKING:
    from rich.console import Console

    from voz.config import Recognition, Ros2
    from voz.events import Event, Warning
    from voz.language.files import LanguageFiles
    from voz.live.messages import Inbox
    from voz.live.session import Typist
    from voz.pipeline import Pipeline
    from voz.recognition.profiles import Profile
    from voz.recognition.recognizer import Recognizer


Obey: TypeAlias = "Callable[[Pipeline], list[str] | None]"
"""Drives by what is not live; gives what of it could not be read."""


@with_options
def run(
    options: Recognising,
    wav: Annotated[
        list[Path] | None, typer.Option(metavar="FILE", help="Recordings; may be repeated.")
    ] = None,
    more: Annotated[
        list[Path] | None, typer.Argument(metavar="[FILE...]", help="More recordings.")
    ] = None,
    text: Annotated[
        str | None, typer.Option(metavar="FILE|-", help="Typed commands, a line each.")
    ] = None,
    replay: Annotated[
        Path | None, typer.Option(metavar="BAG", help="What a bag has on recognizer/output.")
    ] = None,
    robot: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="console, simulator, ros1, ros2 or MODULE:CLASS; may be repeated.",
        ),
    ] = None,
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Recordings and text at their own pace.")
    ] = False,
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the simulator's way, .png or .svg.")
    ] = None,
    animation: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Show the simulator move, .gif or .mp4.")
    ] = None,
    bag: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Keep what is published: .mcap, .db3, .bag, or none."),
    ] = None,
    events: Annotated[
        str | None, typer.Option(metavar="FILE|-", help="Write all events as JSON lines.")
    ] = None,
    no_sound: Annotated[bool, typer.Option("--no-sound", help="Do not speak.")] = False,
    no_half_duplex: Annotated[
        bool, typer.Option("--no-half-duplex", help="Listen while the robot speaks: a headset.")
    ] = False,
    no_safety: Annotated[
        bool, typer.Option("--no-safety", help="The bare command rules; see the README.")
    ] = False,
    device: DeviceOption = None,
    listening: Annotated[
        bool, typer.Option("--listening", help='Obey from the start, without "start speech".')
    ] = False,
    record: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Keep what is heard, for a test set of your own."),
    ] = None,
    listen_ros: Annotated[
        bool, typer.Option("--listen-ros", help="Obey another recogniser on ROS 2, too.")
    ] = False,
    profile: ProfileOption = None,
    adapt: Annotated[
        bool,
        typer.Option("--adapt", help="Learn the speaker and the microphone, also for later runs."),
    ] = False,
) -> None:
    """Drive a robot by your voice, or by recordings or typed commands.

    With a microphone, space stops the robot at once and commands may be typed too. In a text,
    `-` alone on a line lets a cycle of 0.1 s pass with no command.

    Example: voz run --wav audio_fixtures/long/session.wav --robot console,simulator
    """
    from voz import pipeline
    from voz.bags import bag_of, check_bag
    from voz.language.files import read_sentences
    from voz.live.quiet import quiet_libraries
    from voz.robot.robots import have_a_clock, robot_names

    recordings = [*(wav or []), *(more or [])]
    sources = [bool(source) for source in (recordings, text, replay)]
    if sum(sources) > 1:
        raise ConfigError("say what to obey: either --wav FILE... or --text FILE or --replay BAG")
    live = not any(sources)
    if record and not live:
        raise ConfigError("--record keeps what a microphone hears: leave out --wav and --text")
    settings = options.settings(
        safety={"enabled": False if no_safety else None},
        speech={
            "enabled": False if no_sound else None,
            "half_duplex": False if no_half_duplex else None,
        },
        robot=robot or None,
    )
    names = robot_names(settings.robot)
    clocked = live or realtime or have_a_clock(names)
    unreadable: list[str] | None = None
    with ExitStack() as files:
        if live:
            files.enter_context(quiet_libraries())
        stream = sys.stderr if events == "-" else sys.stdout
        plan = Plan(names, live, clocked, stream, _terminal(stream), picture, animation)
        plan.check()
        if bag:
            check_bag(bag)
        language = options.language(settings)
        if not (text or replay):
            place = _microphone(device) if live else "recordings"
            recognizer = files.enter_context(
                _recognizer(language, settings.recognition, profile, place if adapt else None)
            )
        if text:
            obey = _text(open_text(text, "r", files), language)
        elif replay:
            obey = _bag(replay, language)
        elif recordings:
            obey = partial(pipeline.drive_by_recordings, paths=recordings, recognizer=recognizer)
        log = [_event_log(open_text(events, "w", files))] if events else []
        inbox: Inbox = SimpleQueue()
        take: Callable[[Warning], None] = inbox.put if clocked else lambda w: drive.emit(w)
        robots = files.enter_context(robots_of(plan, settings, take))
        receivers = [*robots.receivers, *log]
        if bag:
            receivers.append(files.enter_context(bag_of(bag)))
        if live:
            from voz.live.session import run_live

            run_live(
                receivers,
                settings,
                recognizer,
                read_sentences(language),
                inbox,
                device=device,
                listening=listening,
                terminal=plan.terminal,
                record=record,
                lost=robots.lost,
                extra=robots.view,
                also=_other_recogniser(settings.ros2) if listen_ros else None,
            )
        voice = settings.speech.voice if settings.speech.enabled else None
        kind = _by_the_clock(robots.lost, inbox) if clocked else pipeline.Pipeline
        with pipeline.running(receivers, settings.safety, voice, listening, kind) as drive:
            unreadable = obey(drive)
    if unreadable:
        raise typer.Exit(SOME_UNREADABLE)


def _text(lines: Iterable[str], language: LanguageFiles) -> Obey:
    from voz.language.files import read_sentences
    from voz.pipeline import drive_by_text

    return partial(drive_by_text, lines=lines, commands=read_sentences(language))


def _bag(path: Path, language: LanguageFiles) -> Obey:
    from voz.bags import read_sayings
    from voz.language.files import read_sentences
    from voz.pipeline import drive_by_bag

    commands = read_sentences(language)
    return partial(drive_by_bag, path=path, sayings=read_sayings(path), commands=commands)


def _by_the_clock(
    lost: Mapping[str, Callable[[], str | None]], inbox: Inbox
) -> Callable[..., Pipeline]:
    from voz.realtime import RealtimePipeline

    return partial(RealtimePipeline, lost=lost, inbox=inbox)


def _microphone(device: str | None) -> str:
    from voz.audio.devices import choose

    return choose(device).name


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
    language: LanguageFiles, settings: Recognition, profile: str | None, place: str | None
) -> Iterator[Recognizer]:
    """Load the recogniser; with a place, what it learns there is kept from run to run."""
    from voz.recognition.profiles import USUAL_PROFILE, learnt_file, load_profile, save_learnt
    from voz.recognition.recognizer import Recognizer

    known = load_profile(profile) if profile else None
    if place is None:
        yield Recognizer(language, settings, known)
        return
    learnt = learnt_file(profile or USUAL_PROFILE, place)
    recognizer = Recognizer(language, settings, _with_learnt(known, learnt), learning=True)
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


def _event_log(stream: IO[str]) -> Callable[[Event], None]:
    from voz.events import to_json

    def receive(event: Event) -> None:
        stream.write(f"{to_json(event)}\n")  # at once: a signal ends the run between two calls
        stream.flush()

    return receive
