"""Loads a recognizer in one call."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from voz.api.recognizer import Recognizer
from voz.errors import CommandsError
from voz.files import is_file
from voz.language.language_files import LanguageFiles, find_language
from voz.printable import shown_value
from voz.recognition.profiles import load_profile
from voz.records import check_iterable, check_path, check_type
from voz.settings import Recognition


def load(
    commands: str | PathLike[str] | Iterable[str] | None = None,
    settings: Recognition | None = None,
    profile: str | None = None,
) -> Recognizer:
    """Load a recognizer for any number of recordings; it takes a third of a second.

    Args:
        commands: English sentences or templates: a list of them, or a file with one on each line;
            or a folder that `voz build-lm` made, in any language. None takes `lm/` if it exists,
            else the files that come with voz.
        settings: of the recognition; None takes the defaults.
        profile: the name of a profile of `voz calibrate`; None for no speaker.

    Raises:
        CommandsError: the list cannot be used.
        LanguageError: the language files cannot be used.
        ConfigError: there is no such profile, a model in the settings cannot be read, or an
            argument has another type.
    """
    settings = Recognition() if settings is None else settings
    check_type(Recognition, settings, "settings")
    known = None
    if profile is not None:
        check_type(str, profile, "profile")
        known = load_profile(profile)
    with open_language(commands) as language:
        return Recognizer(language, settings, known)


@contextmanager
def open_language(
    commands: str | PathLike[str] | Iterable[str] | None,
) -> Iterator[LanguageFiles]:
    """Find the language files of a folder, or write those of a list for a `with` block."""
    given: Path | list[str]
    if commands is None or isinstance(commands, str | PathLike):
        path = None if commands is None else Path(check_path(commands, "commands"))
        if path is None or not is_file(path):
            yield find_language(path)
            return
        given = path
    else:
        given = _lines(commands)
    with TemporaryDirectory(prefix="voz-") as folder:  # its files are read once
        yield _write_files(given, Path(folder))


def _write_files(commands: Path | list[str], folder: Path) -> LanguageFiles:
    from voz.language.build import write_files
    from voz.language.command_source import read_lines, read_list

    source = read_list(commands) if isinstance(commands, Path) else read_lines(commands)
    write_files(source, folder)
    return LanguageFiles(folder)


def _lines(commands: Iterable[str]) -> list[str]:
    """Check the lines of a list."""
    is_list = isinstance(commands, Iterable)
    lines: list[Any] = list(check_iterable(commands, "commands")) if is_list else [commands]
    for line in lines:
        if not isinstance(line, str):
            what = f"{shown_value(line)} is no command"
            raise CommandsError(what, "give a list of texts, or a folder")
    return lines
