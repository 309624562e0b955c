"""Everything that is generated from the command list. An edge: it reads and writes files."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

import msgspec
from msgspec.structs import replace

from voz.errors import CommandsError, LanguageError
from voz.files import read_bytes, replaced
from voz.language import alike
from voz.language.alike_picture import MOST_PICTURED, draw
from voz.language.checks import fingerprint, locked
from voz.language.commands import MAX_BYTES, at_most, check_english, parse_commands
from voz.language.confusion import AlikePair, sound_alike
from voz.language.dictionaries import pronounce_by
from voz.language.files import PACKAGED, LanguageFiles, read_sentences
from voz.language.grammar import jsgf
from voz.language.letter_to_sound import guess
from voz.language.lexicon import (
    GUESS,
    PRONUNCIATIONS,
    LexiconEntry,
    parse_pronunciations,
    pronounce,
    read_cmudict,
)
from voz.language.mixing import mean_the_same, pairs_of_many
from voz.language.ngram import arpa
from voz.language.spoken import Spoken
from voz.language.templates.commands import Commands, plain_commands
from voz.language.templates.compiling import Compiled
from voz.language.templates.compiling import compiled as compile_templates
from voz.language.templates.grammar import structured_jsgf
from voz.language.templates.loading import is_templates, read_templates
from voz.language.templates.stored import as_text

if TYPE_CHECKING:
    from voz.language.languages import OtherLanguage


@dataclass(frozen=True)
class BuildResult:
    """What was built.

    Attributes:
        sentences: how many sentences the language has.
        words: how many different words they have.
        warnings: what the user should know, one line each.
        paths: the files written.
    """

    sentences: int
    words: int
    warnings: tuple[str, ...]
    paths: tuple[Path, ...]


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
    compiled: Compiled | None = None
    spoken: Spoken | None = None
    read: Mapping[Path, bytes] = MappingProxyType({})


def build(commands: Path, out: Path, given: Given | None = None) -> BuildResult:
    """Generate all language files from a command list.

    Args:
        commands: the command list; a `pronunciations.txt` beside it is used.
        out: the folder to write to; it is made if need be.
        given: what the list holds, if that is known already.

    Returns:
        What there is to tell the user.

    Raises:
        CommandsError: the list or the pronunciations cannot be read or used.
        LanguageError: the files cannot be written.
    """
    given = given or read_list(commands)
    contents = _contents(given, out)
    _write(contents, out)
    warnings = (*given.warnings, *_guess_warnings(given), *_alike_warnings(given))
    paths = tuple(out / name for name in contents)
    return BuildResult(len(given.commands), len(given.entries), warnings, paths)


def check(commands: Path, out: Path, given: Given | None = None) -> list[str]:
    """Compare the files in a folder with what would be generated, and write nothing.

    Args:
        commands: the command list.
        out: the folder of the language files.
        given: what the list holds, if that is known already.

    Returns:
        The names of the files that are missing or differ; none if all is up to date.

    Raises:
        CommandsError: the list or the pronunciations cannot be read or used.
    """
    contents = _contents(given or read_list(commands), out)
    old = [LanguageFiles(out).templates, LanguageFiles(out).spoken]
    stale = [path.name for path in old if path.exists() and path.name not in contents]
    return [*(name for name, text in contents.items() if not _holds(out / name, text)), *stale]


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
        return _read_templates(commands, language)
    parsed = parse_commands(data, str(commands))
    known, places = plain_commands(parsed.sentences), parsed.places()
    entries, spoken = _pronounced(commands, places, language), language and language.spoken
    return Given(parsed.name, known, entries, places, parsed.warnings, spoken=spoken)


def _read_templates(commands: Path, language: OtherLanguage | None) -> Given:
    source, read = read_templates(commands)
    compiled = compile_templates(source)
    words = set(compiled.commands.vocabulary)
    places = {word: place for word, place in compiled.places.items() if word in words}
    entries, spoken = _pronounced(commands, places, language), language and language.spoken
    return Given(
        source.name, compiled.commands, entries, places, compiled.warnings, compiled, spoken, read
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
        return pairs_of_many(commands, phones, distances)
    pairs = sound_alike(commands.listed, phones, distances=distances)
    return [pair for pair in pairs if not mean_the_same(commands, pair.first, pair.second)]


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


def generate(
    sentences: Sequence[str],
    entries: Mapping[str, LexiconEntry],
    grammar: str | None = None,
    templates: str | None = None,
    spoken: str | None = None,
) -> dict[str, str]:
    """Generate the contents of all language files. Does no I/O.

    Args:
        sentences: normalised sentences, each once: all, or of very many some.
        entries: the pronunciations of all their words, sorted by word.
        grammar: that of all sentences, where only some are given.
        templates: what templates were compiled to; None for a plain list.
        spoken: which language it is; None for voz's usual English.

    Returns:
        The content of each file by its name; the same for the same arguments.
    """
    files = LanguageFiles(Path())
    log = (f"{word}\t{e.origin}\t{phones}" for word, e in entries.items() for phones in e.phones)
    contents = {
        files.dictionary: _lines(_dictionary(entries)),
        files.lm: arpa(sentences),
        files.grammar: jsgf(sentences) if grammar is None else grammar,
        files.sentences: _lines([f"<s> {sentence} </s>" for sentence in sentences]),
        files.vocabulary: _lines(list(entries)),
        files.pronounce_log: _lines(list(log)),
    }
    if templates is not None:
        contents[files.templates] = templates
    if spoken is not None:
        contents[files.spoken] = spoken
    named = {path.name: text for path, text in contents.items()}
    return {**named, files.fingerprint.name: fingerprint(named)}


def _contents(given: Given, out: Path) -> dict[str, str]:
    spoken = _as_json(given.spoken, out) if given.spoken else None
    if given.compiled is None:
        return generate(given.commands.listed, given.entries, spoken=spoken)
    commands, templates = given.commands, given.compiled.templates
    sources = {
        os.path.relpath(path.absolute(), out.absolute()): sha256(data).hexdigest()
        for path, data in given.read.items()
    }
    grammar = None if commands.few else structured_jsgf([one.expression for one in templates])
    text = as_text(commands, sources)
    return generate(commands.examples(), given.entries, grammar, text, spoken)


def _as_json(spoken: Spoken, out: Path) -> str:
    model = Path(spoken.acoustic_model or "")
    if not model.is_absolute():  # the settings name it from where the user is
        spoken = replace(spoken, acoustic_model=os.path.relpath(model.absolute(), out.absolute()))
    return f"{msgspec.json.encode(spoken).decode()}\n"


def _dictionary(entries: Mapping[str, LexiconEntry]) -> list[str]:
    """Write the dictionary's lines; the second pronunciation of a word is called `word(2)`."""
    return [
        f"{word if number == 1 else f'{word}({number})'}\t{phones}"
        for word, entry in entries.items()
        for number, phones in enumerate(entry.phones, start=1)
    ]


def _lines(lines: Sequence[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def _pronounced(
    commands: Path, places: Mapping[str, str], language: OtherLanguage | None
) -> dict[str, LexiconEntry]:
    """Find out how words are pronounced."""
    own = commands.parent / PRONUNCIATIONS
    phones = language.spoken.phones if language else None
    user = parse_pronunciations(_read_text(own), str(own), phones) if own.exists() else {}
    if language:
        return pronounce_by(places, user, language.dictionary, language.rules)
    check_english(places)
    return pronounce(places, user, read_cmudict(), guess)


def _phones(entries: Mapping[str, LexiconEntry]) -> dict[str, tuple[str, ...]]:
    return {word: entry.phones for word, entry in entries.items()}


def _read_text(path: Path) -> bytes:
    return read_bytes(path, CommandsError, "give a readable text file", MAX_BYTES)


def _holds(path: Path, text: str) -> bool:
    try:
        return path.read_bytes() == text.encode()
    except OSError:
        return False


def _guess_warnings(given: Given) -> tuple[str, ...]:
    """Tell the user which pronunciations nobody wrote."""
    guessed = {word: entry for word, entry in given.entries.items() if entry.origin == GUESS}
    each = [
        f'{given.places[word]}: "{word}" is in no dictionary; {entry.phones[0]} is a guess: '
        f"correct it in {PRONUNCIATIONS} beside the list"
        for word, entry in guessed.items()
    ]
    name = LanguageFiles(Path()).pronounce_log.name
    summary = (
        f"{given.name}: {len(each)} words are in no dictionary and their pronunciations are "
        f"guesses (see {name}): correct them in {PRONUNCIATIONS} beside the list"
    )
    return at_most(each, summary)


def _alike_warnings(given: Given) -> tuple[str, ...]:
    """Tell the user which commands sound alike."""
    brought = read_sentences(LanguageFiles(PACKAGED))
    if given.commands.few and set(given.commands) == set(brought):
        return ()  # docs/commands.md tells of these
    return alike.warnings(closest(given))


def _write(contents: Mapping[str, str], out: Path) -> None:
    """Write all files, or none: each is complete under another name before any is replaced.

    The fingerprint is the first to be: whatever ends this, what is left does not fit it.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        with locked(out, fcntl.LOCK_EX):
            with ExitStack() as last_first:
                for name, text in contents.items():
                    file = last_first.enter_context(replaced(out / name, "wb"))
                    file.write(text.encode())
                    file.flush()  # a full disk is told before any is replaced
            for old in (LanguageFiles(out).templates, LanguageFiles(out).spoken):
                if old.name not in contents:  # the list had templates before, or was in Spanish
                    old.unlink(missing_ok=True)
    except OSError as error:
        raise LanguageError(
            f"{out}: cannot be written ({error.strerror}); give a folder that you may write to"
        ) from None
