"""Reads what users write: the command list and pronunciations. Does I/O."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from voz.language.dictionaries import pronounce_from
from voz.language.espeak import pronounce_by_espeak, with_ipa
from voz.language.formats.command_list import (
    CommandList,
    files_of_folder,
    folder_of,
    is_templates,
    left_out_of_folder,
    parse_commands,
    read_file_or_names,
    read_templates,
    read_user_file,
)
from voz.language.formats.notation import has_templates, parse_templates
from voz.language.pronunciation import (
    LexiconEntry,
    check_english,
    guess,
    parse_pronunciations,
    pronounce,
    read_cmudict,
    words_in_capitals,
)
from voz.language.sentences.command_set import Commands, plain_commands
from voz.language.sentences.spelling import ENGLISH
from voz.language.sentences.templates import TemplateSource, in_language
from voz.language.sentences.text_lines import PRONUNCIATIONS_FILE, error_at
from voz.language.similarity import (
    SimilarPair,
    distinct_pairs,
    find_similar,
    similar_pairs_by_sampling,
)
from voz.language.similarity_report import MAX_COMPARED_COMMANDS
from voz.language.spoken_language import LanguageInfo, OtherLanguage
from voz.language.template_compiler import CompiledTemplates, compile_templates
from voz.language.word_neighbors import everyday_words, find_rivals, neighbors

UNNAMED_LIST = "the list of commands"
"""What messages call a list that is not in a file."""


@dataclass(frozen=True)
class CommandSource:
    """What a user wrote, ready to generate files from."""

    name: str  # what messages call the list
    commands: Commands  # its sentences and what they mean
    entries: dict[str, LexiconEntry]  # how their words are pronounced
    places: Mapping[str, str]  # where each word stands first, as `FILE:LINE`
    warnings: tuple[str, ...]  # what the user should know, one line each
    compiled: CompiledTemplates | None = None  # of templates; None for a plain list
    spoken: LanguageInfo | None = None  # the language; None is English
    # The bytes of each file that it was read from, the list first.
    files_read: Mapping[Path, bytes] = field(default_factory=dict)


def read_list(commands: Path, language: OtherLanguage | None = None) -> CommandSource:
    """Read a command list of any format, and how its words are pronounced; raises CommandsError.

    A `pronunciations.txt` beside it is used. Of a folder all lists are one. No language is English.
    """
    if commands.is_dir():
        return _read_folder(commands, language)
    return _read_list(commands, language)


def _read_folder(folder: Path, language: OtherLanguage | None) -> CommandSource:
    lists = files_of_folder(folder)
    left_out = left_out_of_folder(folder, lists)
    source = _read_list(lists[0] if len(lists) == 1 else folder, language)
    return replace(source, warnings=(*left_out, *source.warnings))


def _read_list(commands: Path, language: OtherLanguage | None) -> CommandSource:
    data = read_file_or_names(commands)
    if is_templates(commands, data):
        source, read = read_templates(commands)
        compiled = _of_templates(source, read.values(), folder_of(commands), language)
        return replace(compiled, files_read=read)
    parsed = parse_commands(data, str(commands))
    plain = _of_sentences(parsed, data, commands.parent, language)
    return replace(plain, files_read={commands: data})


def read_lines(lines: Iterable[str]) -> CommandSource:
    """Read the lines of an English command list, in voz's notation; raises CommandsError."""
    data = "\n".join(lines).encode(errors="surrogatepass")
    if not has_templates(data):
        return _of_sentences(parse_commands(data, UNNAMED_LIST), data)
    source = parse_templates(data, UNNAMED_LIST)
    for name, place in source.imports:
        raise error_at(place, f"import works only in files; insert the lines of {name} here")
    return _of_templates(source, [data])


def _of_sentences(
    parsed: CommandList,
    text: bytes,
    folder: Path | None = None,
    language: OtherLanguage | None = None,
) -> CommandSource:
    known, places = plain_commands(parsed.sentences), parsed.places()
    entries = pronounce_words(folder, places, language, [text])
    spoken = language.spoken if language else None
    return CommandSource(parsed.name, known, entries, places, parsed.warnings, spoken=spoken)


def _of_templates(
    source: TemplateSource,
    texts: Collection[bytes],
    folder: Path | None = None,
    language: OtherLanguage | None = None,
) -> CommandSource:
    if language:
        source = in_language(source, language.spoken.code)
    compiled = compile_templates(source)
    compiled.commands.language = language.spoken.code if language else ENGLISH
    words = set(compiled.commands.vocabulary)
    places = {word: place for word, place in compiled.places.items() if word in words}
    entries = pronounce_words(folder, places, language, texts)
    spoken = language.spoken if language else None
    return CommandSource(
        source.name, compiled.commands, entries, places, compiled.warnings, compiled, spoken
    )


def similar_pairs(source: CommandSource) -> list[SimilarPair]:
    """Find sentences that sound alike and mean different things; in a long list only some."""
    commands, phones = source.commands, _phones(source.entries)
    distances = source.spoken.distances if source.spoken else None
    if len(commands) > MAX_COMPARED_COMMANDS:
        pairs = similar_pairs_by_sampling(commands, phones, distances)
    else:
        pairs = find_similar(commands.listed, phones, distances=distances)
    return distinct_pairs(pairs, commands)


def everyday_neighbors(source: CommandSource) -> dict[str, list[str]]:
    """Find phrases of everyday English words that sound most like each command of a list.

    Of a list that is too long to compare only some commands are looked at.
    """
    phones = _phones(source.entries)
    rivals = find_rivals(phones, read_cmudict())
    others = {word for ways in rivals.values() for words in ways.values() for word in words}
    common = everyday_words(others)
    commands = source.commands
    few = len(commands) <= MAX_COMPARED_COMMANDS
    chosen = commands.listed if few else commands.sample(MAX_COMPARED_COMMANDS)
    found = {text: neighbors(text, phones, rivals, common) for text in chosen}
    return {
        text: [phrase for phrase in near if phrase not in commands] for text, near in found.items()
    }


def pronounce_words(
    folder: Path | None,
    places: Mapping[str, str],
    language: OtherLanguage | None = None,
    texts: Collection[bytes] = (),
) -> dict[str, LexiconEntry]:
    """Find out how words are pronounced, by a `pronunciations.txt` in the folder, too.

    `places` has where each stands, for messages; words in capitals in `texts`, which the user wrote
    in UTF-8, may be spelled. No language is English.

    Raises:
        CommandsError: nobody knows how to say one of them.
    """
    own = folder / PRONUNCIATIONS_FILE if folder else None
    phones = language.phones if language else None
    user = (
        parse_pronunciations(read_user_file(own), str(own), phones) if own and own.exists() else {}
    )
    if language and language.dictionary is None:
        return pronounce_by_espeak(places, user, language.spoken.name)
    if language and language.dictionary is not None:
        entries = pronounce_from(places, user, language.dictionary, language.rules)
        return with_ipa(entries, language.spoken.name)
    check_english(places)
    capitals = words_in_capitals(text.decode(errors="replace") for text in texts)
    return pronounce(places, user, read_cmudict(), guess, capitals)


def _phones(entries: Mapping[str, LexiconEntry]) -> dict[str, tuple[str, ...]]:
    return {word: entry.phones for word, entry in entries.items()}
