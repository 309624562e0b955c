"""`voz run`: drives a robot."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import IO, TYPE_CHECKING, Annotated

import typer

from voz.cli.exit_codes import SOME_UNREADABLE
from voz.cli.options import ProfileOption, Recognising, with_options
from voz.cli.terminal import open_text, warn
from voz.errors import ConfigError

if TYPE_CHECKING:
    from voz.events import Event
    from voz.recognition.profiles import Profile


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
    events: Annotated[
        str | None, typer.Option(metavar="FILE|-", help="Write all events as JSON lines.")
    ] = None,
    no_sound: Annotated[bool, typer.Option("--no-sound", help="Do not speak.")] = False,
    no_safety: Annotated[
        bool, typer.Option("--no-safety", help="The bare command rules; see the README.")
    ] = False,
    profile: ProfileOption = None,
    adapt: Annotated[
        bool,
        typer.Option("--adapt", help="Learn the speaker and the microphone, also for later runs."),
    ] = False,
) -> None:
    """Drive a robot by recordings or typed commands.

    In typed text, `-` alone on a line lets a cycle of 0.1 s pass with no command.

    Example: voz run --wav audio_fixtures/long/session.wav --events events.jsonl
    """
    from voz import pipeline
    from voz.language.files import read_sentences
    from voz.recognition.profiles import USUAL_PROFILE, learnt_file, load_profile, save_learnt
    from voz.recognition.recognizer import Recognizer
    from voz.robot.console import ConsoleRobot

    recordings = [*(wav or []), *(more or [])]
    if bool(recordings) == bool(text):
        raise ConfigError("say what to obey: either --wav FILE... or --text FILE, see --help")
    settings = options.settings(
        safety={"enabled": False if no_safety else None},
        speech={"enabled": False if no_sound else None},
    )
    language = options.language(settings)
    unreadable: list[str] = []
    with ExitStack() as files:
        if text:
            lines, commands = open_text(text, "r", files), read_sentences(language)
        else:
            known = load_profile(profile) if profile else None
            learnt = learnt_file(profile or USUAL_PROFILE, "recordings")
            if adapt:
                known = _with_learnt(known, learnt)
            recognizer = Recognizer(language, settings.recognition, known, learning=adapt)
            if adapt:
                files.callback(lambda: warn(save_learnt(learnt, recognizer.learnt)))
        console = ConsoleRobot(sys.stderr if events == "-" else sys.stdout)
        receivers: list[Callable[[Event], None]] = [console.receive]
        if events:
            receivers.append(_event_log(open_text(events, "w", files)))
        voice = settings.speech.voice if settings.speech.enabled else None
        with pipeline.running(receivers, settings.safety, voice) as robot:
            if text:
                pipeline.drive_by_text(robot, lines, commands)
            else:
                unreadable = pipeline.drive_by_recordings(robot, recordings, recognizer)
    if unreadable:
        raise typer.Exit(SOME_UNREADABLE)


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

    return lambda event: print(to_json(event), file=stream, flush=True)
