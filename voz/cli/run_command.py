"""`voz run`: drives a robot."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import typer

from voz.cli.options import with_options
from voz.cli.run_options import RunOptions, require_page
from voz.cli.text_io import info, open_text, warn
from voz.errors import AudioError, CommandsError, ConfigError
from voz.files import data_folder
from voz.process.signals import SOME_UNREADABLE
from voz.texts import language_of, text

if TYPE_CHECKING:
    from voz.config import Config
    from voz.language.language_files import LanguageFiles
    from voz.language.sentences.command_set import Commands
    from voz.recognition.engine import RecognitionEngine
    from voz.run.clocks import Source
    from voz.run.live import OtherRecognizer, Page, RecorderOpener, ServiceMaker
    from voz.run.robots import RunRobots
    from voz.run.session import Session
    from voz.run.spec import Part, RunSpec
    from voz.settings import Recording, Ros2
    from voz.terminal.live_terminal import LiveTerminal


BROWSER_DEVICE = "browser"
"""The name of the microphone of the operator's page, for `--device`."""

NO_DEVICE = "none"
"""For `--device` where only other programs drive, by `--wyoming`."""

NO_MICROPHONE_ADVICE = (
    ", or use `--web` to speak into a browser, `--text -` to type commands, "
    "or `--wav FILE` for recordings"
)
"""What to do besides connecting a microphone, where there is none."""


@with_options
def run(options: RunOptions) -> None:
    """Drive a robot by your voice, or by recordings or typed commands.

    With a microphone, the space bar, Esc and Ctrl-Z stop the robot at once. Commands may be typed
    too; a space inside of one does not stop. In a text, `-` alone on a line lets a cycle of 0.1 s
    pass with no command.

    Example: voz run --wav audio_fixtures/long/session.wav --robot console,simulator
    """
    from voz.process.standard_streams import quiet_libraries
    from voz.run.session import Session

    options.check()
    if options.adapt:
        warn("--adapt is no longer used: the network need not learn a voice")
    settings = options.settings()
    options.check_outputs(settings)
    options.check_service(settings)
    unreadable: list[str] = []
    with ExitStack() as opened:
        opened.enter_context(quiet_libraries())
        Session(_spec(options, settings, opened, unreadable)).run()
    if unreadable:
        raise typer.Exit(SOME_UNREADABLE)


def _spec(
    options: RunOptions, settings: Config, opened: ExitStack, unreadable: list[str]
) -> RunSpec:
    """Say what the run consists of; `unreadable` will get a line for each unreadable recording."""
    from voz.language.language_files import list_name, read_commands
    from voz.process.standard_streams import unblocked_output
    from voz.robot.factory import need_real_time, robot_names
    from voz.run.command_check import matched_settings, mismatches
    from voz.run.controller import controller_by
    from voz.run.parts import by_items
    from voz.run.robots import CONSOLE, SIMULATOR
    from voz.run.spec import RunSpec

    names = robot_names(settings.robot)
    in_real_time = options.live or options.realtime or need_real_time(names)
    if in_real_time:
        opened.enter_context(unblocked_output())
    robots = _robots(options, names)
    _renew_language(settings)
    language = options.language(settings)
    commands = read_commands(language)
    settings = matched_settings(settings, commands)
    listening = _listening(options, settings, commands, list_name(language))
    spec = RunSpec(
        controller=controller_by(settings, listening),
        settings=settings,
        outputs=_outputs(options, robots),
    )
    for line in mismatches(commands, settings, not {CONSOLE, SIMULATOR}.issuperset(names)):
        info(line)
    load = partial(_recognizer, options, settings, language)
    if options.live:
        return replace(spec, parts=[_live(options, settings, robots.terminal, load, opened)])
    source, parts = _source(options, settings, commands, load, opened=opened, unreadable=unreadable)
    return by_items(spec, source, parts, in_real_time=in_real_time)


def _listening(options: RunOptions, settings: Config, commands: Commands, where: str) -> bool:
    """Whether commands are obeyed from the start; refuses a list that drives and cannot stop."""
    from voz.run.command_check import begins_listening, check_list

    check_list(commands, settings.table, where)
    if options.listening or begins_listening(commands, settings.table):
        return options.listening
    obeyed = "no command of the list begins the listening: commands are obeyed from the start"
    info(text(obeyed, language_of(settings.language.name)))
    return True


def _renew_language(settings: Config) -> None:
    """Make the language files again if their list was edited since; a broken one is a warning."""
    from voz.language.language_files import find_language
    from voz.run.command_check import build_stale_files

    try:
        if told := build_stale_files(find_language(settings.lm, settings.language), settings):
            info(told)
    except (CommandsError, ConfigError) as error:
        warn(f"{error}; the commands of before stay")


def _robots(options: RunOptions, names: list[str]) -> RunRobots:
    """Choose the robots; refuses, before the run, what cannot be written after it."""
    from voz.run.robots import RunRobots

    stream = sys.stderr if options.events == "-" else sys.stdout
    robots = RunRobots(
        names=names,
        live=options.live,
        stream=stream,
        terminal=_terminal(stream),
        watchdog=options.watchdog,
        picture=options.picture,
        animation=options.animation,
        verbose=options.verbose,
        info=info,
        warn=warn,
    )
    robots.check()
    if options.bag:
        from voz.apps.recordings.bags import check_bag

        check_bag(options.bag)
    return robots


def _terminal(stream: TextIO) -> LiveTerminal | None:
    if not stream.isatty():
        return None
    from rich.console import Console

    from voz.terminal.live_terminal import LiveTerminal

    return LiveTerminal(Console(file=stream))


def _outputs(options: RunOptions, robots: RunRobots) -> list[Part]:
    """List what gets the events; a file that cannot be written is known before a robot is open."""
    from voz.cli.text_io import event_log
    from voz.run.parts import write_events

    outputs: list[Part] = [robots.open]
    if options.events:
        log = event_log(options.events)
        outputs.insert(0, partial(write_events, name=options.events, opening=log))
    if options.bag:
        from voz.apps.recordings.bags import write_bag

        bag = write_bag(options.bag)
        outputs.append(partial(write_events, name=str(options.bag), opening=bag))
    return outputs


def _source(
    options: RunOptions,
    settings: Config,
    commands: Commands,
    load: Callable[[], RecognitionEngine],
    *,
    opened: ExitStack,
    unreadable: list[str],
) -> tuple[Source, list[Part]]:
    """Open what drives the robot, and the parts that it needs."""
    from voz.run import sources
    from voz.run.parts import hear_answers

    halts = settings.table.halts
    if options.text:
        lines = open_text(options.text, opened)
        return lambda now: sources.typed_items(lines, commands, halts, now), []
    if options.replay:
        from voz.apps.recordings.bags import read_sayings

        bag, content = options.replay, read_sayings(options.replay)
        return lambda _: sources.bag_items(bag, content, commands, halts), []
    recognizer = load()
    recorded = partial(sources.recorded_items, options.recordings, recognizer, unreadable)
    return lambda _: recorded(), [partial(hear_answers, recognizer=recognizer)]


def _chosen_microphone(options: RunOptions, language: str) -> str | None:
    """Find the microphone; None if it is the operator's browser. Raises AudioError.

    Where a robot that other programs drive has none, it is `NO_DEVICE`.
    """
    from voz.audio.microphone import choose_microphone

    if options.web and options.device == BROWSER_DEVICE:
        return None
    if options.wyoming and options.device == NO_DEVICE:
        return NO_DEVICE
    try:
        return choose_microphone(options.device, NO_MICROPHONE_ADVICE).name
    except AudioError:
        if options.web and options.device is None:
            return None
        if options.wyoming and options.device is None:
            heard = "there is no microphone: only typed commands and Wyoming clients are obeyed"
            info(text(heard, language))
            return NO_DEVICE
        raise


@contextmanager
def _page(
    options: RunOptions, language: str, browser_listens: bool
) -> Iterator[Callable[[Session], Page]]:
    """Take the page's address for a `with` block, and show it; raises ConfigError."""
    require_page()
    from voz.apps.web.live_page import LivePage
    from voz.apps.web.web_server import open_page_address, qr_code

    authority = data_folder("certificates") if options.https else None
    with open_page_address(options.web_host, options.web_port, authority) as address:
        info(text("operator page: {link}", language, link=address.link))
        if address.access.needs_token and sys.stderr.isatty():  # else it is a log
            print(qr_code(address.link), file=sys.stderr, flush=True)
        yield partial(LivePage, address=address, browser_listens=browser_listens)


def _live(
    options: RunOptions,
    settings: Config,
    terminal: LiveTerminal | None,
    load: Callable[[], RecognitionEngine],
    opened: ExitStack,
) -> Part:
    """Open what hears, and say what drives besides."""
    from voz.hearing.microphone_thread import no_sound, sound_card
    from voz.run.command_reload import SettingsFile
    from voz.run.live import drive_live

    language = language_of(settings.language.name)
    microphone = _chosen_microphone(options, language)
    opening = _page(options, language, microphone is None)
    page = opened.enter_context(opening) if options.web else None
    recognizer = load()
    file = options.settings_file
    return partial(
        drive_live,
        recognizer=recognizer,
        sound=no_sound() if microphone == NO_DEVICE else sound_card(options.device),
        page=page,
        service=_service(options.wyoming, options.zeroconf) if options.wyoming else None,
        other_recognizer=_other_recognizer(settings.ros2) if options.listen_ros else None,
        record=_recorder(options.record, settings.recording) if options.record else None,
        settings_file=SettingsFile(file, options.settings) if file else None,
        terminal=terminal,
        announce=info,
    )


def _service(uri: str, announce: bool) -> ServiceMaker:
    from voz.apps.wyoming.robot_service import RobotService

    return partial(RobotService, uri=uri, announce=announce)


def _recorder(folder: Path, settings: Recording) -> RecorderOpener:
    from voz.apps.recordings.recorder import Recorder

    return partial(Recorder, folder, settings.gigabytes)


def _other_recognizer(settings: Ros2) -> OtherRecognizer:
    from voz.ros2 import ROS2_SOURCE, listen_to_recognizer

    return lambda take_text, failed: listen_to_recognizer(
        settings, lambda text: take_text(text, ROS2_SOURCE), failed
    )


def _recognizer(
    options: RunOptions, settings: Config, language: LanguageFiles
) -> RecognitionEngine:
    """Load the recognizer."""
    from voz.recognition.engine import RecognitionEngine
    from voz.recognition.profiles import load_profile

    known = load_profile(options.profile, warn) if options.profile else None
    recognizer = RecognitionEngine(language, settings.recognition, known)
    warn(recognizer.name_advice)
    return recognizer
