"""Everything that is generated from the command list. An edge: it reads and writes files."""

from __future__ import annotations

import fcntl
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from voz.control.controller import COMMANDS
from voz.errors import CommandsError, LanguageError
from voz.files import read_bytes, replaced
from voz.language import alike
from voz.language.checks import fingerprint, locked
from voz.language.commands import MAX_BYTES, CommandList, at_most, parse_commands
from voz.language.confusion import AlikePair, sound_alike
from voz.language.files import LanguageFiles
from voz.language.grammar import jsgf
from voz.language.letter_to_sound import guess
from voz.language.lexicon import (
    GUESS,
    PRONUNCIATIONS,
    Entry,
    parse_pronunciations,
    pronounce,
    read_cmudict,
)
from voz.language.ngram import arpa


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


def build(commands: Path, out: Path) -> BuildResult:
    """Generate all language files from a command list.

    Args:
        commands: the command list; a `pronunciations.txt` beside it is used.
        out: the folder to write to; it is made if need be.

    Returns:
        What there is to tell the user.

    Raises:
        CommandsError: the list or the pronunciations cannot be read or used.
        LanguageError: the files cannot be written.
    """
    parsed, entries = _read(commands)
    contents = generate(parsed.sentences, entries)
    _write(contents, out)
    warnings = (
        *parsed.warnings,
        *_guess_warnings(entries, parsed),
        *_alike_warnings(entries, parsed),
    )
    paths = tuple(out / name for name in contents)
    return BuildResult(len(parsed.sentences), len(entries), warnings, paths)


def check(commands: Path, out: Path) -> list[str]:
    """Compare the files in a folder with what would be generated, and write nothing.

    Args:
        commands: the command list.
        out: the folder of the language files.

    Returns:
        The names of the files that are missing or differ; none if all is up to date.

    Raises:
        CommandsError: the list or the pronunciations cannot be read or used.
    """
    parsed, entries = _read(commands)
    contents = generate(parsed.sentences, entries)
    return [name for name, text in contents.items() if not _holds(out / name, text)]


def closest_commands(commands: Path) -> list[AlikePair]:
    """Find the commands of a list that sound alike, and write nothing.

    Args:
        commands: the command list.

    Returns:
        The pairs, the most alike first.

    Raises:
        CommandsError: the list or the pronunciations cannot be used, or it is too long.
    """
    parsed, entries = _read_few(commands)
    return sound_alike(parsed.sentences, _phones(entries))


def draw_alike(commands: Path, picture: Path) -> None:
    """Draw how alike the commands of a list sound.

    Args:
        commands: the command list.
        picture: the picture to write, PNG or SVG by its ending.

    Raises:
        CommandsError: the list or the pronunciations cannot be used, or it is too long.
        VozError: the picture cannot be drawn.
    """
    parsed, entries = _read_few(commands)
    alike.draw(parsed.sentences, _phones(entries), picture)


def generate(sentences: Sequence[str], entries: Mapping[str, Entry]) -> dict[str, str]:
    """Generate the contents of all language files. Does no I/O.

    Args:
        sentences: normalised sentences, each once.
        entries: the pronunciations of all their words, sorted by word.

    Returns:
        The content of each file by its name; the same for the same arguments.
    """
    files = LanguageFiles(Path())
    log = (f"{word}\t{e.origin}\t{phones}" for word, e in entries.items() for phones in e.phones)
    contents = {
        files.dictionary: _lines(_dictionary(entries)),
        files.lm: arpa(sentences),
        files.grammar: jsgf(sentences),
        files.sentences: _lines([f"<s> {sentence} </s>" for sentence in sentences]),
        files.vocabulary: _lines(list(entries)),
        files.pronounce_log: _lines(list(log)),
    }
    named = {path.name: text for path, text in contents.items()}
    return {**named, files.fingerprint.name: fingerprint(named)}


def _dictionary(entries: Mapping[str, Entry]) -> list[str]:
    """Write the dictionary's lines; the second pronunciation of a word is called `word(2)`."""
    return [
        f"{word if number == 1 else f'{word}({number})'}\t{phones}"
        for word, entry in entries.items()
        for number, phones in enumerate(entry.phones, start=1)
    ]


def _lines(lines: Sequence[str]) -> str:
    return "".join(f"{line}\n" for line in lines)


def _read(commands: Path) -> tuple[CommandList, dict[str, Entry]]:
    """Read a command list and find out how its words are pronounced."""
    parsed = parse_commands(_read_text(commands), str(commands))
    own = commands.parent / PRONUNCIATIONS
    user = parse_pronunciations(_read_text(own), str(own)) if own.exists() else {}
    return parsed, pronounce(parsed.places(), user, read_cmudict(), guess)


def _read_few(commands: Path) -> tuple[CommandList, dict[str, Entry]]:
    """Read a command list whose commands are to be compared with each other."""
    parsed, entries = _read(commands)
    if too_many := _too_many(parsed):
        raise CommandsError(too_many)
    return parsed, entries


def _too_many(parsed: CommandList) -> str:
    """Say that a list is too long to compare its commands; empty if it is not."""
    if len(parsed.sentences) <= alike.MOST_COMMANDS:
        return ""
    return (
        f"{parsed.name}: has {len(parsed.sentences)} commands, too many to find those that sound "
        f"alike; give a list of at most {alike.MOST_COMMANDS} to `voz build-lm --alike`"
    )


def _phones(entries: Mapping[str, Entry]) -> dict[str, tuple[str, ...]]:
    return {word: entry.phones for word, entry in entries.items()}


def _read_text(path: Path) -> bytes:
    return read_bytes(path, CommandsError, "give a readable text file", MAX_BYTES)


def _holds(path: Path, text: str) -> bool:
    try:
        return path.read_bytes() == text.encode()
    except OSError:
        return False


def _guess_warnings(entries: Mapping[str, Entry], parsed: CommandList) -> tuple[str, ...]:
    """Tell the user which pronunciations nobody wrote."""
    places = parsed.places()
    guessed = {word: entry for word, entry in entries.items() if entry.origin == GUESS}
    each = [
        f'{places[word]}: "{word}" is in no dictionary; {entry.phones[0]} is a guess: '
        f"correct it in {PRONUNCIATIONS} beside the list"
        for word, entry in guessed.items()
    ]
    name = LanguageFiles(Path()).pronounce_log.name
    summary = (
        f"{parsed.name}: {len(each)} words are in no dictionary and their pronunciations are "
        f"guesses (see {name}): correct them in {PRONUNCIATIONS} beside the list"
    )
    return at_most(each, summary)


def _alike_warnings(entries: Mapping[str, Entry], parsed: CommandList) -> tuple[str, ...]:
    """Tell the user which commands sound alike."""
    if set(parsed.sentences) == set(COMMANDS):  # docs/commands.md tells of these
        return ()
    if too_many := _too_many(parsed):
        return (too_many,)
    return alike.warnings(sound_alike(parsed.sentences, _phones(entries)))


def _write(contents: Mapping[str, str], out: Path) -> None:
    """Write all files, or none: each is complete under another name before any is replaced.

    The fingerprint is the first to be: whatever ends this, what is left does not fit it.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        with locked(out, fcntl.LOCK_EX), ExitStack() as last_first:
            for name, text in contents.items():
                file = last_first.enter_context(replaced(out / name, "wb"))
                file.write(text.encode())
                file.flush()  # a full disk is told before any is replaced
    except OSError as error:
        raise LanguageError(
            f"{out}: cannot be written ({error.strerror}); give a folder that you may write to"
        ) from None
