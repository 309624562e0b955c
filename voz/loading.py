"""A recognizer in one call, for programs of others."""

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
    """Load a recognizer; it takes a third of a second, and serves any number of recordings.

    Args:
        commands: the folder of the language files that `voz build-lm` made, or a list of English
            sentences or templates, as the lines of a file; None takes the files in `lm/`, where
            there are any, or those that come with voz.
        settings: how sure it must be, and the like; None takes the usual ones.
        profile: the name of what `voz calibrate` knows of a speaker; None for nobody's.

    Raises:
        CommandsError: the list cannot be used.
        LanguageError: the language files cannot be used.
        ConfigError: there is no such profile, a model in the settings cannot be read, or an
            argument is something else.
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
    from voz.language.build import write_files
    from voz.language.command_source import read_lines

    lines = list(commands) if isinstance(commands, Iterable) else [commands]
    for line in lines:
        if not isinstance(line, str):
            raise CommandsError(f"{line!r} is no command; give a list of texts, or a folder")
    with TemporaryDirectory(prefix="voz-") as folder:  # whose files are read once
        write_files(read_lines(lines), Path(folder))
        return Recognizer(LanguageFiles(Path(folder)), settings, profile)
