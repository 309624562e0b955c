"""A language as recognition needs it: its commands, how words are said, and what is compared."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path

from voz.errors import CommandsError, ConfigError
from voz.events import NO, YES
from voz.language.language_files import (
    LanguageFiles,
    check_files,
    list_sources,
    read_commands,
    read_ipa,
    read_language_info,
    read_pronunciations,
    read_rival_words,
)
from voz.language.pronunciation import GUESS_ORIGIN, dictionary_entries, ipa_entries
from voz.language.sentences.command_set import Commands
from voz.language.similarity import WordDistances
from voz.language.spoken_language import LanguageInfo, OtherLanguage, check_acoustic_model
from voz.language.word_neighbors import Rivals
from voz.settings import Recognition
from voz.texts import ENGLISH, language_of, text


@dataclass(frozen=True)
class Language:
    """Commands and pronunciations."""

    files: LanguageFiles  # the language files, which pocketsphinx reads too
    commands: Commands  # all commands
    dictionary: Mapping[str, Phones]  # the phones of each word; variants, as `the(2)`, are words
    pronunciations: Mapping[str, Phones]  # the same, with British ones
    spoken: LanguageInfo  # which language it is, and its acoustic model
    rivals: Rivals  # what sounds much like the words of the commands
    # The pronunciations for the network, of a language that has others for pocketsphinx.
    ipa: Mapping[str, Phones] = field(default_factory=dict)
    # Words that no dictionary has, beside those of the commands.
    guessed: frozenset[str] = frozenset()

    @cached_property
    def pocketsphinx_words(self) -> Mapping[str, Phones]:
        """The pronunciations that pocketsphinx needs, with the rounded vowel."""
        return with_rounded(self.pronunciations) if self.spoken.is_english else self.pronunciations

    @property
    def network_words(self) -> Mapping[str, Phones]:
        """The pronunciations that the network hears; empty if it does not know the language."""
        return self.pronunciations if self.spoken.is_english else self.ipa


def load_language(files: LanguageFiles) -> Language:
    """Read a language; raises LanguageError if a file is missing, damaged or does not match."""
    check_files(files)
    dictionary = read_pronunciations(files)
    spoken = read_language_info(files)
    check_acoustic_model(spoken, files.folder)
    said = with_british(dictionary) if spoken.is_english else dictionary
    rivals = read_rival_words(files)
    ipa = read_ipa(files)
    return Language(files, read_commands(files), dictionary, said, spoken, rivals, ipa)


MAX_NEVER_MISSED = 8
"""Always compare at most this many sentences of each template that must not be missed."""


class Shortlist:
    """Chooses the commands that are compared; those of `never_missed` always are."""

    def __init__(self, language: Language, never_missed: Collection[str], most: int) -> None:
        """Prepare for a language, commands that are always compared, and the most to compare."""
        self._commands = language.commands
        self._most = most
        self._sound = WordDistances(spellings(language.pronunciations), language.spoken.distances)
        self.never_missed = self._commands.named(never_missed, MAX_NEVER_MISSED)

    @property
    def compares_all(self) -> bool:
        """Whether all commands are compared."""
        return len(self._commands) <= self._most

    def similar_to(self, text: str) -> list[str]:
        """The whole list, or a command and those that sound like it; empty text is no command."""
        if self.compares_all:
            return self._commands.listed
        if not text:
            return self.never_missed
        near = self._commands.neighbors(text, self._most, self._sound)
        return list(dict.fromkeys([text, *self.never_missed, *near]))[: self._most]


SETTING = "[recognition] name"


def with_more_words(language: Language, settings: Recognition) -> Language:
    """Add the words of the robot's name, and of answers to what it asks, to a language.

    Raises:
        ConfigError: the search is not for whole commands, nobody knows how to say the name, a
            command is the same or begins so, or the language has no such answers.
    """
    name = settings.name
    if not settings.more_than_commands:
        return language
    if not language.spoken.uses_default_model:
        raise ConfigError(
            f"`name` and `ask` of [recognition] are not for an acoustic model of your own, as "
            f"that of {language.spoken.name}"
        )
    has_questions = language.spoken.is_english or language_of(language.spoken.code) != ENGLISH
    if settings.ask != "never" and not has_questions:
        raise ConfigError(f"`ask` of [recognition]: voz asks nothing in {language.spoken.name}")
    if settings.search == "lm":
        raise ConfigError('`name` and `ask` of [recognition] need search = "grammar"')
    if name and (name in language.commands or language.commands.has_continuation(name)):
        raise ConfigError(f'{SETTING}: a command is or begins with "{name}"; give another name')
    # These build lists, which most runs do not.
    from voz.language.command_source import pronounce_words
    from voz.language.formats.command_list import folder_of

    known = spellings(language.dictionary)
    spoken = None if language.spoken.is_english else OtherLanguage(language.spoken)
    answers = [text(word, language_of(language.spoken.code)) for word in (YES, NO)]
    places = {word: SETTING for word in (*name.split(), *answers) if word not in known}
    sources = list_sources(language.files)
    try:
        entries = pronounce_words(folder_of(sources[0]) if sources else None, places, spoken)
    except CommandsError as error:
        raise ConfigError(str(error)) from None
    more = {word: tuple(phones.split()) for word, phones in dictionary_entries(entries)}
    ipa = {word: tuple(phones.split()) for word, phones in ipa_entries(entries)}
    said = {**language.pronunciations, **(more if spoken else with_british(more))}
    return replace(
        language,
        pronunciations=said,
        ipa=_with_english_phones({**language.ipa, **ipa}, name.split(), said) if spoken else {},
        guessed=frozenset(word for word in entries if entries[word].origin == GUESS_ORIGIN),
    )


def _with_english_phones(
    ipa: Mapping[str, Phones], words: Collection[str], english: Mapping[str, Phones]
) -> dict[str, Phones]:
    """Let the network hear the words of a name by English phones, which the name's weights know."""
    others = {entry: way for entry, way in ipa.items() if plain_word(entry) not in words}
    return others | {entry: way for entry, way in english.items() if plain_word(entry) in words}


Phones = tuple[str, ...]

BRITISH_FILE = Path(__file__).with_name("british.tsv")
"""Words that are said otherwise outside America, with their phones there."""


def with_british(dictionary: Mapping[str, Phones]) -> dict[str, Phones]:
    """Add the pronunciations of `BRITISH_FILE` to a dictionary; variants are words, as `the(2)`.

    More (`start` without r) makes commands alike.
    """
    return _with_variants(dictionary, lambda word, _: _british().get(word, ()))


def with_rounded(dictionary: Mapping[str, Phones]) -> dict[str, Phones]:
    """Add the rounded vowel of `stop` and `rock`, which most accents have, for pocketsphinx.

    The network hears that vowel as a symbol of the American one.
    """
    return _with_variants(dictionary, lambda word, known: [_rounded(word, way) for way in known])


def _with_variants(
    dictionary: Mapping[str, Phones], variants: Callable[[str, list[Phones]], Iterable[Phones]]
) -> dict[str, Phones]:
    more = dict(dictionary)
    for word, known in spellings(dictionary).items():
        new = [way for way in dict.fromkeys(variants(word, known)) if way not in known]
        for number, way in enumerate(new, start=len(known) + 1):
            more[f"{word}({number})"] = way
    return more


def spellings(dictionary: Mapping[str, Phones]) -> dict[str, list[Phones]]:
    """All pronunciations of each word of a dictionary."""
    found: dict[str, list[Phones]] = {}
    for name, phones in dictionary.items():
        found.setdefault(plain_word(name), []).append(phones)
    return found


def added(before: Iterable[str], after: Mapping[str, Phones]) -> dict[str, Phones]:
    """The entries that a dictionary has more than before."""
    there = set(before)
    return {name: phones for name, phones in after.items() if name not in there}


@cache
def _british() -> dict[str, list[Phones]]:
    found: dict[str, list[Phones]] = {}
    for line in BRITISH_FILE.read_text(encoding="utf-8").splitlines():
        word, _, phones = line.partition("\t")
        found.setdefault(word, []).append(tuple(phones.split()))
    return found


def _rounded(word: str, phones: Phones) -> Phones:
    """Replace AA by AO where an o is written, but not before R (`sorry` keeps it)."""
    if "o" not in word:
        return phones
    pairs = zip(phones, (*phones[1:], ""), strict=True)
    return tuple("AO" if phone == "AA" and after != "R" else phone for phone, after in pairs)


def plain_word(name: str) -> str:
    """The word of an entry of a dictionary, which may be a variant, as `the(2)`."""
    return name.partition("(")[0]
