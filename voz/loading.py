"""Loads a recognizer in one call."""

from __future__ import annotations

from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory

from voz.errors import CommandsError
from voz.language.generated.language_files import LanguageFiles, find_language
from voz.recognition.recognizer import Recognizer
from voz.recognition.speaker.profiles import Profile, load_profile
from voz.records import check_type
from voz.settings import Recognition


def load(
    commands: str | PathLike[str] | Iterable[str] | None = None,
    settings: Recognition | None = None,
    profile: str | None = None,
) -> Recognizer:
    """Load a recognizer for any number of recordings; it takes a third of a second.

    Args:
        commands: a folder that `voz build-lm` made, or a list of English sentences or templates, as
            the lines of a file; None takes `lm/` if it exists, else the files that come with voz.
        settings: of the recognition; None takes the defaults.
        profile: the name of a profile of `voz calibrate`; None for no speaker.

    Raises:
        CommandsError: the list cannot be used.
        LanguageError: the language files cannot be used.
        ConfigError: there is no such profile, a model in the settings cannot be read, or an
            argument has another type.
    """
    settings = Recognition() if settings is None else settings
    known = None
    if profile is not None:
        check_type(str, profile, "profile")
        known = load_profile(profile)
    if commands is None or isinstance(commands, str | PathLike):
        folder = None if commands is None else Path(commands)
        return Recognizer(find_language(folder), settings, known)
    return _load_list(commands, settings, known)


def _load_list(
    commands: Iterable[str], settings: Recognition, profile: Profile | None
) -> Recognizer:
    with TemporaryDirectory(prefix="voz-") as folder:  # its files are read once
        return Recognizer(write_list(commands, Path(folder)), settings, profile)


def write_list(commands: Iterable[str], folder: Path) -> LanguageFiles:
    """Write the language files of a list into a folder; raises CommandsError."""
    from voz.language.build import write_files
    from voz.language.command_source import read_lines

    lines = list(commands) if isinstance(commands, Iterable) else [commands]
    for line in lines:
        if not isinstance(line, str):
            raise CommandsError(f"{line!r} is no command; give a list of texts, or a folder")
    write_files(read_lines(lines), folder)
    return LanguageFiles(folder)
