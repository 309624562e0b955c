"""A language as recognition needs it: checked, read and given its accents once, then passed on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from voz.language.checks import check_files
from voz.language.files import LanguageFiles, read_commands, read_pronunciations
from voz.language.templates.commands import Commands
from voz.recognition.accents import Phones, with_accents


class Language(NamedTuple):
    """The commands of a language and how their words are said.

    Attributes:
        files: where it is from; pocketsphinx reads them itself.
        commands: all sentences and what they mean.
        dictionary: the phones of each word, as the files have them; variants are words.
        pronunciations: the same, and how its words are said in other accents.
    """

    files: LanguageFiles
    commands: Commands
    dictionary: Mapping[str, Phones]
    pronunciations: Mapping[str, Phones]


def load_language(files: LanguageFiles) -> Language:
    """Read a language.

    Raises:
        LanguageError: a file is missing or damaged, or they do not belong together.
    """
    check_files(files)
    dictionary = read_pronunciations(files)
    return Language(files, read_commands(files), dictionary, with_accents(dictionary))
