"""A language as recognition needs it: checked, read and given its accents once, then passed on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from voz.language.acoustics.language_info import LanguageInfo, english
from voz.language.generated.file_checks import check_files
from voz.language.generated.language_files import (
    LanguageFiles,
    read_commands,
    read_language_info,
    read_pronunciations,
)
from voz.language.sentences.command_set import Commands
from voz.recognition.accents import Phones, with_accents


class Language(NamedTuple):
    """The commands of a language and how their words are said.

    Attributes:
        files: where it is from; pocketsphinx reads them itself.
        commands: all sentences and what they mean.
        dictionary: the phones of each word, as the files have them; variants are words.
        pronunciations: the same, and how its words are said in other accents.
        spoken: which language it is, and its acoustic model.
    """

    files: LanguageFiles
    commands: Commands
    dictionary: Mapping[str, Phones]
    pronunciations: Mapping[str, Phones]
    spoken: LanguageInfo = english()


def load_language(files: LanguageFiles) -> Language:
    """Read a language.

    Raises:
        LanguageError: a file is missing or damaged, or they do not belong together.
    """
    check_files(files)
    dictionary = read_pronunciations(files)
    spoken = read_language_info(files)
    if not spoken.uses_default_model:
        from voz.language.other_languages import check_acoustic_model

        check_acoustic_model(spoken, files.folder)
    said = with_accents(dictionary) if spoken.is_english else dictionary
    return Language(files, read_commands(files), dictionary, said, spoken)
