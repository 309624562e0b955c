"""What a user gives: the command list, how its words are pronounced, what in it sounds alike.

An edge: it reads files.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from voz.errors import CommandsError
from voz.files import read_bytes
from voz.language.acoustics.spoken_language import Spoken
from voz.language.compiling.compile_templates import CompiledTemplates, compile_templates
from voz.language.formats.plain_list import CommandList, parse_commands
from voz.language.formats.template_files import is_templates, read_templates
from voz.language.formats.template_list import has_templates, parse_templates
from voz.language.formats.text_lines import MAX_TEXT_BYTES
from voz.language.pronunciation.dictionaries import pronounce_by
from voz.language.pronunciation.letter_to_sound import guess
from voz.language.pronunciation.lexicon import (
    PRONUNCIATIONS,
    LexiconEntry,
    check_english,
    parse_pronunciations,
    pronounce,
    read_cmudict,
)
from voz.language.sentences.command_set import Commands, plain_commands
from voz.language.sentences.location import error_at
from voz.language.sentences.template_source import TemplateSource
from voz.language.similarity import alike_report as alike
from voz.language.similarity.alike_picture import MOST_PICTURED, draw
from voz.language.similarity.confusion import AlikePair, sound_alike
from voz.language.similarity.distinct_pairs import distinct
from voz.language.similarity.sampled_pairs import pairs_of_many

if TYPE_CHECKING:
    from voz.language.other_languages import OtherLanguage

IN_NO_FILE = "the list of commands"
"""What messages call a list that is in no file."""


class Given(NamedTuple):
    """What a user wrote, ready to generate files from.

    Attributes:
        name: what messages call the list.
        commands: its sentences and what they mean.
        entries: how their words are pronounced.
        places: where each word stands first, as `FILE:LINE`.
        warnings: what the user should know, one line each.
        compiled: of templates; None for a plain list.
        spoken: the language, if it is not voz's usual English.
        read: the bytes of each file that templates were read from.
    """

    name: str
    commands: Commands
    entries: dict[str, LexiconEntry]
    places: Mapping[str, str]
    warnings: tuple[str, ...]
    compiled: CompiledTemplates | None = None
    spoken: Spoken | None = None
    read: Mapping[Path, bytes] = MappingProxyType({})


def read_list(commands: Path, language: OtherLanguage | None = None) -> Given:
    """Read a command list, and find out how its words are pronounced.

    Args:
        commands: a plain list or templates, in voz's notation or in that of another program; a
            `pronunciations.txt` beside it is used.
        language: what is spoken; None is English.

    Raises:
        CommandsError: it or the pronunciations cannot be read or used.
    """
    data = _read_text(commands)
    if is_templates(commands, data):
        source, read = read_templates(commands)
        return _of_templates(source, read, commands.parent, language)
    return _of_sentences(parse_commands(data, str(commands)), commands.parent, language)


def list_of(lines: Iterable[str]) -> Given:
    """Read the lines of a command list in English that is in no file.

    Args:
        lines: sentences or templates, in voz's notation.

    Raises:
        CommandsError: they cannot be used.
    """
    data = "\n".join(lines).encode(errors="surrogatepass")
    if not has_templates(data):
        return _of_sentences(parse_commands(data, IN_NO_FILE))
    source = parse_templates(data, IN_NO_FILE)
    for name, place in source.imports:
        raise error_at(place, f"only a file imports others; put the lines of {name} here")
    return _of_templates(source, {})


def _of_sentences(
    parsed: CommandList, folder: Path | None = None, language: OtherLanguage | None = None
) -> Given:
    known, places = plain_commands(parsed.sentences), parsed.places()
    entries, spoken = _pronounced(folder, places, language), language and language.spoken
    return Given(parsed.name, known, entries, places, parsed.warnings, spoken=spoken)


def _of_templates(
    source: TemplateSource,
    read: Mapping[Path, bytes],
    folder: Path | None = None,
    language: OtherLanguage | None = None,
) -> Given:
    compiled = compile_templates(source)
    words = set(compiled.commands.vocabulary)
    places = {word: place for word, place in compiled.places.items() if word in words}
    entries, spoken = _pronounced(folder, places, language), language and language.spoken
    return Given(
        source.name,
        compiled.commands,
        entries,
        places,
        compiled.warnings,
        compiled,
        spoken,
        read,
    )


def closest_commands(commands: Path) -> list[AlikePair]:
    """Find the commands of a list that sound alike, and write nothing.

    Args:
        commands: the command list.

    Returns:
        The pairs, the most alike first.

    Raises:
        CommandsError: the list or the pronunciations cannot be used.
    """
    return closest(read_list(commands))


def closest(given: Given) -> list[AlikePair]:
    """Find what sounds alike and does not mean the same; in a long list some of it."""
    commands, phones = given.commands, _phones(given.entries)
    distances = given.spoken.distances if given.spoken else None
    if len(commands) > alike.MOST_COMMANDS:
        pairs = pairs_of_many(commands, phones, distances)
    else:
        pairs = sound_alike(commands.listed, phones, distances=distances)
    return distinct(pairs, commands)


def draw_alike(commands: Path, picture: Path, given: Given | None = None) -> None:
    """Draw how alike the commands of a list sound.

    Args:
        commands: the command list.
        picture: the picture to write, PNG or SVG by its ending.
        given: what the list holds, if that is known already.

    Raises:
        CommandsError: the list or the pronunciations cannot be used, or it is too long.
        VozError: the picture cannot be drawn.
    """
    given = given or read_list(commands)
    if len(given.commands) > MOST_PICTURED:
        raise CommandsError(
            f"{given.name}: has {len(given.commands):,} sentences, too many for a picture; "
            f"give a list of at most {MOST_PICTURED}"
        )
    distances = given.spoken.distances if given.spoken else None
    draw(given.commands.listed, _phones(given.entries), picture, distances)


def _pronounced(
    folder: Path | None, places: Mapping[str, str], language: OtherLanguage | None
) -> dict[str, LexiconEntry]:
    """Find out how words are pronounced; a file in the folder may say it."""
    own = folder / PRONUNCIATIONS if folder else None
    phones = language.spoken.phones if language else None
    user = parse_pronunciations(_read_text(own), str(own), phones) if own and own.exists() else {}
    if language:
        return pronounce_by(places, user, language.dictionary, language.rules)
    check_english(places)
    return pronounce(places, user, read_cmudict(), guess)


def _phones(entries: Mapping[str, LexiconEntry]) -> dict[str, tuple[str, ...]]:
    return {word: entry.phones for word, entry in entries.items()}


def _read_text(path: Path) -> bytes:
    return read_bytes(path, CommandsError, "give a readable text file", MAX_TEXT_BYTES)
