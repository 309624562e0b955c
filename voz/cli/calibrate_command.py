"""`voz calibrate`: a profile of a speaker."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from voz.cli.options import CommonOptions, DeviceOption, with_options
from voz.cli.text_io import show, warn
from voz.errors import ConfigError

if TYPE_CHECKING:
    from voz.apps.recordings.calibration import Calibration, Said, Score
    from voz.language.language_files import LanguageFiles
    from voz.recognition.engine import RecognitionEngine
    from voz.settings import Recognition


@with_options
def calibrate(
    options: CommonOptions,
    *,
    name: Annotated[str, typer.Argument(metavar="[NAME]", help="Of the profile.")] = "default",
    wav: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Recordings with a manifest.tsv; else a microphone."),
    ] = None,
    device: DeviceOption = None,
    list_profiles: Annotated[
        bool, typer.Option("--list", help="Show the names of all profiles.")
    ] = False,
    delete: Annotated[
        bool, typer.Option("--delete", help="Delete the profile and its recordings.")
    ] = False,
) -> None:
    """Find out in two minutes how well a speaker is understood.

    Shows commands to say and what is heard, and keeps the recordings. What is heard wrongly is
    asked for once more. If many are heard right and refused, the profile trusts the speaker more.
    `voz run --profile NAME` and `voz decode --profile NAME` use it. Ctrl-C stops, and the same
    call goes on.

    Example: voz calibrate ana
    """
    from voz.recognition import profiles

    if list_profiles:
        show(*profiles.profile_names())
    elif delete:
        profiles.delete_profile(name)
    else:
        from voz.process.standard_streams import quiet_libraries

        settings = options.settings()
        with quiet_libraries():
            make_profile(name, wav, device, options.language(settings), settings.recognition)


def make_profile(
    name: str,
    wav: Path | None,
    device: str | None,
    language: LanguageFiles,
    settings: Recognition,
) -> None:
    """Record a speaker, or read recordings; find the profile, keep it, and show what it gains.

    `wav` is a folder with recordings and their manifest; None records by the device.
    """
    from voz.apps.recordings.calibration import read_recordings
    from voz.apps.recordings.manifest import MANIFEST_NAME
    from voz.language.language_files import read_sentences
    from voz.recognition.engine import RecognitionEngine
    from voz.recognition.profiles import profile_folder

    commands = read_sentences(language)
    own = profile_folder(name) / "recordings"
    recognizer = RecognitionEngine(language, settings)
    if wav is None:
        _record(name, own, device, commands, recognizer)
    said = read_recordings((wav or own) / MANIFEST_NAME, commands)
    if wav:
        _warn_of_misheard(said, recognizer)
    found = _calibrate(said, language, settings, name)
    show(
        *report(found, len(said)),
        f"written: {profile_folder(name)}",
        f"use it:  voz run --profile {name}",
    )


def report(found: Calibration, sentences: int) -> list[str]:
    """Write what was found as a table, and what is kept."""
    lines = [
        f"{sentences} sentences:",
        f"{'':20}{'right':>8}{'obeyed':>8}{'wrongly obeyed':>17}",
    ]
    for title, score in (("before", found.before), ("with the profile", found.after)):
        lines.append(f"{title:20}{_score_columns(score)}")
    odds = math.exp(found.profile.log_odds)
    kept = "as sure as for others" if odds == 1 else f"{odds:.0f} times the odds"
    return [*lines, f"kept: {kept}"]


def _score_columns(score: Score) -> str:
    right, obeyed, wrong = (n / score.sentences for n in (score.right, score.accepted, score.wrong))
    return f"{right:8.2f}{obeyed:8.2f}{wrong:17.2f}"


def _record(
    name: str,
    folder: Path,
    device: str | None,
    commands: list[str],
    recognizer: RecognitionEngine,
) -> None:
    from rich.console import Console

    from voz.apps.recordings.calibration import (
        MIN_SENTENCES,
        choose_prompts,
        missing_prompts,
        read_saved_recordings,
        record_prompts,
    )
    from voz.audio.microphone import open_microphone

    asked = choose_prompts(commands, name)
    if len(set(asked)) < MIN_SENTENCES:
        raise ConfigError(
            f"the language has {len(set(asked))} commands; to calibrate, add some to its list "
            f"until there are {MIN_SENTENCES}"
        )
    console = Console()
    left = missing_prompts(asked, read_saved_recordings(folder, commands))
    if not left:
        return
    if len(left) < len(asked):
        console.print(f"{len(asked) - len(left)} of {len(asked)} are recorded already")
    try:
        with open_microphone(device) as blocks:
            record_prompts(left, blocks, recognizer, folder=folder, name=name, console=console)
    except SystemExit:  # Ctrl-C
        console.print("stopped; what is recorded is kept, and the same call goes on")
        raise


def _warn_of_misheard(said: list[Said], recognizer: RecognitionEngine) -> None:
    """Warn of recordings that are not understood as their list says."""
    from voz.apps.recordings.calibration import check_recording

    for sentence in said:
        right, heard = check_recording(sentence.text, sentence.samples, recognizer)
        if not right:
            warn(f"{sentence.file}: should be {sentence.text}; heard: {heard}")


def _calibrate(
    said: list[Said], language: LanguageFiles, settings: Recognition, name: str
) -> Calibration:
    """Find the profile and keep it, with a progress bar."""
    from rich.console import Console
    from rich.progress import Progress

    from voz.apps.recordings.calibration import DOUBLINGS, calibrate
    from voz.recognition.profiles import save_profile

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("Trying what helps", total=len(DOUBLINGS))
        found = calibrate(said, language, settings, lambda: bar.advance(task))
        save_profile(name, found.profile)
    return found
