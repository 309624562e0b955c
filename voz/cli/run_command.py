"""`voz run`: drives a robot."""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO, TypeAlias

import typer

from voz.cli.options import with_options
from voz.cli.run_options import RunOptions
from voz.cli.run_page import NO_DEVICE, chosen_microphone, page_of, page_site
from voz.cli.run_robots import CONSOLE, SIMULATOR, RobotPlan, open_robots
from voz.cli.run_service import check_service, service_of
from voz.cli.text_io import info, open_text, warn
from voz.errors import CommandsError, ConfigError
from voz.process.signals import SOME_UNREADABLE

if TYPE_CHECKING:
    from voz.apps.recordings.recorder import Recorder
    from voz.config import Config
    from voz.events import Receiver
    from voz.language.language_files import LanguageFiles
    from voz.language.sentences.command_set import Commands
    from voz.recognition.engine import RecognitionEngine
    from voz.recognition.speaker.profiles import Profile
    from voz.run.command_reload import SettingsFile
    from voz.run.live import OtherRecognizer
    from voz.run.offline import Source
    from voz.run.session import OpenRobots
    from voz.settings import Ros2
    from voz.terminal.live_terminal import LiveTerminal

    RecognizerAt: TypeAlias = Callable[[str], AbstractContextManager[RecognitionEngine]]
    """Loads the recognizer, by the place where it hears: a microphone, or recordings."""


@with_options
def run(options: RunOptions) -> None:
    """Drive a robot by your voice, or by recordings or typed commands.

    With a microphone, the space bar, Esc and Ctrl-Z stop the robot at once. Commands may be typed
    too; a space inside of one does not stop. In a text, `-` alone on a line lets a cycle of 0.1 s
    pass with no command.

    Example: voz run --wav audio_fixtures/long/session.wav --robot console,simulator
    """
    from voz.language.language_files import list_name, read_commands
    from voz.process.standard_streams import quiet_libraries, unblocked_output

    options.check()
    settings = options.settings()
    options.check_outputs(settings)
    check_service(options, settings)
    unreadable: list[str] = []
    with ExitStack() as parts:
        parts.enter_context(quiet_libraries())
        if _has_a_clock(options, settings):
            parts.enter_context(unblocked_output())
        plan = _plan(options, settings)
        _renew_language(settings)
        language = options.language(settings)
        commands = read_commands(language)
        options.listening = _listening(options, settings, commands, list_name(language))
        _report_commands_without_effect(commands, settings, plan)
        _report_unknown_commands(commands, settings)
        recognizer_at = partial(_recognizer, options, settings, language)
        if options.live:
            _run_live(options, settings, plan, recognizer_at, parts)
            return
        source, receivers = _source(
            options, commands, settings.table.halts, recognizer_at, parts, unreadable
        )
        _run_by_files(options, settings, plan, source, receivers)
    if unreadable:
        raise typer.Exit(SOME_UNREADABLE)


def _listening(options: RunOptions, settings: Config, commands: Commands, where: str) -> bool:
    """Whether commands are obeyed from the start; refuses a list that drives and cannot stop."""
    from voz.run.command_check import begins_listening, check_list

    check_list(commands, settings.table, where)
    if options.listening or begins_listening(commands, settings.table):
        return options.listening
    info("no command of the list begins the listening: commands are obeyed from the start")
    return True


def _renew_language(settings: Config) -> None:
    """Make the language files again if their list was edited since; a broken one is a warning."""
    from voz.language.language_files import find_language
    from voz.run.renewal import build_stale_files

    try:
        if told := build_stale_files(find_language(settings.lm), settings):
            info(told)
    except (CommandsError, ConfigError) as error:
        warn(f"{error}; the commands of before stay")


def _report_commands_without_effect(commands: Commands, settings: Config, plan: RobotPlan) -> None:
    """Report commands that are not in the table; robots of others may act on them."""
    from voz.run.command_check import commands_without_effect

    names = commands_without_effect(commands, settings.table)
    if not names or not {CONSOLE, SIMULATOR}.issuperset(plan.names):
        return
    info(f"no line of [commands] in voz.toml says what to do at {_quote_names(names)}")


def _report_unknown_commands(commands: Commands, settings: Config) -> None:
    from voz.run.command_check import accented_form, missing_commands

    own = (settings.commands, *settings.states.values())
    missed = [
        name
        for name in settings.recognition.never_missed
        if name not in settings.table.stops and commands.parse(name) is None
    ]
    names = missing_commands(commands, [*(name for table in own for name in table), *missed])
    accented = {name: other for name in names if (other := accented_form(commands, name))}
    for name, other in accented.items():
        info(f'[commands] has "{name}" and the list "{other}": write both with the same accents')
    if names := [name for name in names if name not in accented]:
        quoted = _quote_names(names)
        info(f"no line of the list of commands is {quoted}: add it, and run `voz build-lm`")


def _quote_names(names: Sequence[str]) -> str:
    shown = " or ".join(f'"{name}"' for name in names[:2])
    return shown + (f" or {len(names) - 2} more" if len(names) > 2 else "")


def _has_a_clock(options: RunOptions, settings: Config) -> bool:
    from voz.robot.factory import need_real_time, robot_names

    return options.live or options.realtime or need_real_time(robot_names(settings.robot))


def _plan(options: RunOptions, settings: Config) -> RobotPlan:
    """Choose the robots; refuses, before the run, what cannot be written after it."""
    from voz.robot.factory import robot_names

    stream = sys.stderr if options.events == "-" else sys.stdout
    plan = RobotPlan(
        robot_names(settings.robot),
        options.live,
        _has_a_clock(options, settings),
        options.watchdog,
        stream,
        _terminal(stream),
        options.picture,
        options.animation,
        options.verbose,
    )
    plan.check()
    if options.bag:
        from voz.apps.recordings.bags import check_bag

        check_bag(options.bag)
    return plan


def _run_live(
    options: RunOptions,
    settings: Config,
    plan: RobotPlan,
    recognizer_at: RecognizerAt,
    parts: ExitStack,
) -> None:
    from voz.hearing.microphone_thread import no_sound
    from voz.inbox import Inbox
    from voz.run.live import LiveOptions, run_live

    microphone = chosen_microphone(options)
    site = parts.enter_context(page_site(options)) if options.web else None
    recognizer = parts.enter_context(recognizer_at(microphone or "browser"))
    inbox = Inbox(settings.table.halts)
    robots = parts.enter_context(_receivers(options, settings, plan, inbox.put))
    live = LiveOptions(
        device=options.device,
        settings_file=_settings_file(options),
        sound=no_sound() if microphone == NO_DEVICE else None,
        listening=options.listening,
        terminal=plan.terminal,
        announce=info,
        record=partial(_recorder, options.record, settings) if options.record else None,
        other_recognizer=_other_recognizer(settings.ros2) if options.listen_ros else None,
        page=page_of(site, lambda: recognizer.commands, robots.view, microphone) if site else None,
        service=service_of(options, recognizer),
    )
    run_live(settings, recognizer, inbox, robots, live)


def _settings_file(options: RunOptions) -> SettingsFile | None:
    from voz.run.command_reload import SettingsFile

    path = options.settings_file
    return SettingsFile(path, options.settings) if path else None


def _run_by_files(
    options: RunOptions,
    settings: Config,
    plan: RobotPlan,
    source: Source,
    receivers: list[Receiver],
) -> None:
    from voz.run.offline import run_paced, run_unpaced

    run_source = run_paced if plan.clocked else run_unpaced
    run_source(
        source,
        settings,
        options.listening,
        lambda put: _receivers(options, settings, plan, put, receivers),
    )


def _source(
    options: RunOptions,
    commands: Commands,
    halts: Collection[str],
    recognizer_at: RecognizerAt,
    parts: ExitStack,
    unreadable: list[str],
) -> tuple[Source, list[Receiver]]:
    """Open what drives the robot, and what of it gets the events.

    `halts` are the commands that leave the robot at rest; `unreadable` gets a line for each
    unreadable file.
    """
    from voz.run import sources
    from voz.run.session import answer_receiver

    if options.text:
        lines = open_text(options.text, parts)
        return lambda now: sources.typed_items(lines, commands, halts, now), []
    if options.replay:
        from voz.apps.recordings.bags import read_sayings

        bag, content = options.replay, read_sayings(options.replay)
        return lambda _: sources.bag_items(bag, content, commands, halts), []
    recognizer = parts.enter_context(recognizer_at("recordings"))
    recorded = sources.recorded_items
    return (
        lambda _: recorded(options.recordings, recognizer, unreadable),
        [answer_receiver(recognizer)],
    )


@contextmanager
def _receivers(
    options: RunOptions,
    settings: Config,
    plan: RobotPlan,
    put: Callable[[Any], None],
    more: Sequence[Receiver] = (),
) -> Iterator[OpenRobots]:
    """Open the robots, and `more` that gets the events; with a clock, each has a queue."""
    from voz.cli.text_io import event_log
    from voz.run.queued import QueuedReceiver

    def open_file(name: str, opening: AbstractContextManager[Receiver]) -> Receiver:
        return parts.enter_context(QueuedReceiver(name, opening, put) if plan.clocked else opening)

    with ExitStack() as parts:
        log = [open_file(options.events, event_log(options.events))] if options.events else []
        robots = parts.enter_context(open_robots(plan, settings, put))
        bag = [open_file(str(options.bag), _bag(options.bag))] if options.bag else []
        yield replace(robots, receivers=[*robots.receivers, *more, *log, *bag])


def _bag(path: Path) -> AbstractContextManager[Receiver]:
    from voz.apps.recordings.bags import write_bag

    return write_bag(path)


def _recorder(folder: Path, settings: Config, warn: Callable[[str], None]) -> Recorder:
    from voz.apps.recordings.recorder import Recorder

    return Recorder(folder, settings.recording.gigabytes, warn)


def _other_recognizer(settings: Ros2) -> OtherRecognizer:
    from voz.ros2 import ROS2_SOURCE, listen_to_recognizer

    return lambda take_text, failed: listen_to_recognizer(
        settings, lambda text: take_text(text, ROS2_SOURCE), failed
    )


def _terminal(stream: TextIO) -> LiveTerminal | None:
    if not stream.isatty():
        return None
    from rich.console import Console

    from voz.terminal.live_terminal import LiveTerminal

    return LiveTerminal(Console(file=stream))


@contextmanager
def _recognizer(
    options: RunOptions, settings: Config, language: LanguageFiles, place: str
) -> Iterator[RecognitionEngine]:
    """Load the recognizer; with --adapt, keep what it learns at this place for later runs."""
    from voz.language.language_files import read_language_info
    from voz.recognition.engine import RecognitionEngine, learned_by
    from voz.recognition.speaker.profiles import (
        USUAL_PROFILE,
        learned_file,
        load_profile,
        save_learned,
    )

    known = load_profile(options.profile) if options.profile else None
    if not options.adapt:
        recognizer = RecognitionEngine(language, settings.recognition, known)
        warn(recognizer.name_advice)
        yield recognizer
        return
    # For each acoustic model, by its digest; English has none.
    where = f"{place} {read_language_info(language).model}".strip()
    learned = learned_file(options.profile or USUAL_PROFILE, where)
    known = _with_learned(known, learned)
    recognizer = RecognitionEngine(language, settings.recognition, known, learning=True)
    warn(recognizer.name_advice)
    try:
        yield recognizer
    finally:
        warn(save_learned(learned, learned_by(recognizer)))


def _with_learned(known: Profile | None, path: Path) -> Profile:
    """Replace what the profile starts from by what was learned in earlier runs."""
    from msgspec.structs import replace

    from voz.recognition.speaker.profiles import Profile, load_learned

    learned, problem = load_learned(path)
    warn(problem)
    known = known or Profile()
    return replace(known, start=learned) if learned.frames else known
