"""A language as recognition needs it, read once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from voz.language.language_files import (
    LanguageFiles,
    check_files,
    read_commands,
    read_language_info,
    read_pronunciations,
)
from voz.language.sentences.command_set import Commands
from voz.language.spoken_language import LanguageInfo
from voz.recognition.accents import Phones, with_british, with_rounded


@dataclass(frozen=True)
class Language:
    """Commands and pronunciations.

    Attributes:
        files: the language files, which pocketsphinx reads too.
        commands: all commands.
        dictionary: the phones of each word; variants, as `the(2)`, are words.
        pronunciations: the same, with British ones.
        spoken: which language it is, and its acoustic model.
        guessed: words that no dictionary has, beside those of the commands.
    """

    files: LanguageFiles
    commands: Commands
    dictionary: Mapping[str, Phones]
    pronunciations: Mapping[str, Phones]
    spoken: LanguageInfo
    guessed: frozenset[str] = frozenset()

    @cached_property
    def pocketsphinx_words(self) -> Mapping[str, Phones]:
        """The pronunciations that pocketsphinx needs, with the rounded vowel."""
        return with_rounded(self.pronunciations) if self.spoken.is_english else self.pronunciations


def load_language(files: LanguageFiles) -> Language:
    """Read a language; raises LanguageError if a file is missing, damaged or does not match."""
    check_files(files)
    dictionary = read_pronunciations(files)
    spoken = read_language_info(files)
    if not spoken.uses_default_model:
        from voz.language.spoken_language import check_acoustic_model

        check_acoustic_model(spoken, files.folder)
    said = with_british(dictionary) if spoken.is_english else dictionary
    return Language(files, read_commands(files), dictionary, said, spoken)
