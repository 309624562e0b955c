"""A command list: plain sentences, or templates in any format with what they import. Does I/O."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from voz.errors import CommandsError
from voz.files import read_bytes, shown_path
from voz.language.formats.notation import has_templates, parse_templates
from voz.language.sentences.command_set import Commands
from voz.language.sentences.spelling import find_unspeakable, first_wording, length_complaint
from voz.language.sentences.templates import Advice, TemplateSource
from voz.language.sentences.text_lines import (
    MAX_TEXT_BYTES,
    PRONUNCIATIONS_FILE,
    Faults,
    content_lines,
    error_at,
    summarize_warnings,
)

MAX_COMMAND_WORDS = 12

EXPECTED_SENTENCES_FILE = "tests.txt"

BESIDE_THE_LIST = (PRONUNCIATIONS_FILE, EXPECTED_SENTENCES_FILE)
"""What belongs to a list and is none."""

RHASSPY_SLOTS = "slots"
"""The folder beside a `sentences.ini` with the lists that it names."""

_GENERATED = "comandos_voz.gram"
"""What is made from a list, with the ending of one."""


def read_user_file(path: Path) -> bytes:
    """Read a text file that a user wrote; raises CommandsError."""
    return read_bytes(path, CommandsError, "give a readable text file", MAX_TEXT_BYTES)


def read_file_or_names(path: Path) -> bytes:
    """Read a text file that a user wrote, of a folder the names in it; raises CommandsError."""
    if path.is_dir():
        return b"\n".join(os.fsencode(file.name) for file in files_of_folder(path))
    return read_user_file(path)


def files_of_folder(folder: Path) -> list[Path]:
    """Return the files of a folder that are one list together, in the order of their names."""
    try:
        files = sorted(path for path in folder.iterdir() if path.is_file())
    except OSError as error:
        raise CommandsError(f"{shown_path(folder)}: {error.strerror}; give another") from None
    files = [path for path in files if path.name not in (*BESIDE_THE_LIST, _GENERATED)]
    found = [path for path in files if has_known_ending(path)]
    return found or [path for path in files if path.suffix == ".txt"]


def left_out_of_folder(folder: Path, taken: Collection[Path]) -> Iterator[str]:
    """Report which lists in a folder are no part of the one that its files are together."""
    for path in sorted(folder.iterdir()):
        within = path.glob("*") if path.name != RHASSPY_SLOTS else ()
        lists = [file for file in within if has_known_ending(file) and file.name != _GENERATED]
        is_list = path.suffix == ".txt" and path.name not in BESIDE_THE_LIST
        if lists or (is_list and path not in taken):
            yield f"{shown_path(path)} is left out; move what you want from it to the other lists"


def folder_of(commands: Path) -> Path:
    """Return the folder of a list, in which is what belongs to it; a folder is its own."""
    return commands if commands.is_dir() else commands.parent


@dataclass(frozen=True)
class CommandList:
    """The sentences of a plain list."""

    name: str  # what messages call the list, mostly its path
    sentences: tuple[str, ...]  # the commands, normalized, each once, in the order of the list
    lines: tuple[int, ...]  # the line number of each sentence, from 1
    warnings: tuple[str, ...] = ()  # what the user should know, one line each

    def places(self) -> dict[str, str]:
        """Where each word first stands, as `FILE:LINE`."""
        places: dict[str, str] = {}
        for sentence, line in zip(self.sentences, self.lines, strict=True):
            for word in sentence.split():
                if word not in places:
                    places[word] = f"{self.name}:{line}"
        return places


def parse_commands(data: bytes, name: str) -> CommandList:
    """Parse a command list, UTF-8: one sentence a line, `#` begins a comment.

    Messages call it `name`. Raises CommandsError.
    """
    lines: dict[str, int] = {}
    repeats: list[str] = []
    faults = Faults()
    for number, text in content_lines(data, name):
        sentence = first_wording(text)
        with faults:
            _check_sentence(text, sentence.split(), f"{name}:{number}")
        first = lines.setdefault(sentence, number)
        if first != number:
            repeats.append(
                f'{name}:{number}: "{sentence}" is repeated (first in line {first}); kept once'
            )
    faults.check()
    if not lines:
        raise CommandsError(f"{name}: contains no command; write one sentence per line")
    summary = f"{name}: {len(repeats)} lines repeat an earlier one; each sentence is kept once"
    return CommandList(
        name, tuple(lines), tuple(lines.values()), summarize_warnings(repeats, summary)
    )


def _check_sentence(text: str, words: list[str], where: str) -> None:
    if found := find_unspeakable(text):
        raise CommandsError(f"{where}: {found[1]}")
    if not words:
        raise CommandsError(f"{where}: has no word; remove this line, or write what is said")
    if len(words) > MAX_COMMAND_WORDS:
        raise CommandsError(
            f"{where}: has {len(words)} words; at most {MAX_COMMAND_WORDS} are allowed"
        )
    if advice := length_complaint(max(words, key=len)):
        raise CommandsError(f"{where}: {advice}")


NEGATION = "!"
"""Before a sentence that must not be a command; alone on a line, before all that follow."""


def failed_expectations(commands: Commands, data: bytes, name: str) -> Iterator[str]:
    """Report each line whose expectation does not hold; raises CommandsError.

    The data has a sentence a line, UTF-8; messages call the file `name`.
    """
    none_follow = False
    for number, line in content_lines(data, name):
        text = line.strip()
        if text == NEGATION:
            none_follow = True
            continue
        wanted = not (none_follow or text.startswith(NEGATION))
        text = text.lstrip(NEGATION).strip()
        parse = commands.parse(text)
        if wanted and parse is None:
            meant = commands.closest_sentence(text)
            perhaps = f'; the nearest is "{meant}"' if meant else ""
            yield f'{name}:{number}: "{text}" should be a command, but is not{perhaps}'
        elif parse and not wanted:
            yield f'{name}:{number}: "{text}" should not be a command, but is "{parse.command}"'


MAX_IMPORTED_FILES = 100


def has_known_ending(path: Path) -> bool:
    """Whether the file is in the format of another program, by its ending."""
    return path.suffix.lower() in PARSERS


def is_templates(path: Path, data: bytes) -> bool:
    """Whether a file has more than plain sentences; a folder may have."""
    if path.is_dir() or has_known_ending(path) or has_templates(data):
        return True
    return bool(_THRESHOLD.search(data))


def read_templates(path: Path) -> tuple[TemplateSource, dict[Path, bytes]]:
    """Read templates with their imports; return them, and the bytes of each file."""
    if not path.is_dir():
        read: dict[Path, bytes] = {}
        return _read(path, read), read
    read = {path: read_file_or_names(path)}
    sources = [_read(file, read) for file in files_of_folder(path) if file not in read]
    if not sources:
        kinds = " or ".join(PARSERS)
        raise CommandsError(f"{shown_path(path)}: has no list; give a folder with {kinds} files")
    whole, *others = sources
    for other in others:
        whole.add(other)
    return replace(whole, name=shown_path(path)), read


def _read(path: Path, read: dict[Path, bytes]) -> TemplateSource:
    data = read[path] = read_user_file(path)
    parse = PARSERS.get(path.suffix.lower(), _keywords if _THRESHOLD.search(data) else _sentences)
    source = parse(data, shown_path(path), path, read)
    for name, place in source.imports:
        other = path.parent / name
        if len(read) >= MAX_IMPORTED_FILES:
            raise error_at(place, f"more than {MAX_IMPORTED_FILES} imported files; merge some")
        if any(_same(other, known) for known in read):
            continue
        try:
            source.add(_read(other, read))
        except CommandsError as error:
            if other in read:
                raise
            raise error_at(place, f"{error}") from None
    return source


def _same(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other)
    except OSError:
        return False


def _sentences(data: bytes, name: str, path: Path, read: dict[Path, bytes]) -> TemplateSource:
    return parse_templates(data, name)


def _rhasspy(data: bytes, name: str, path: Path, read: dict[Path, bytes]) -> TemplateSource:
    from voz.language.formats.rhasspy import parse_rhasspy

    def slots(named: str) -> tuple[str, bytes] | None:
        file = path.parent / RHASSPY_SLOTS / named
        if ".." in file.parts or not file.is_file():
            return None
        data = read[file] = read_user_file(file)
        return shown_path(file), data

    return parse_rhasspy(data, name, slots)


def _yaml(data: bytes, name: str, path: Path, read: dict[Path, bytes]) -> TemplateSource:
    from voz.language.formats.yaml_formats import SENTENCE_SECTIONS, Yaml, parse_hassil, parse_rhino

    text = Yaml(data, name)
    parts = text.mapping(text.root, "intents (of hassil) or a context (of Rhino)")
    if "context" in parts:
        return parse_rhino(text)
    if not parts.keys() & {*SENTENCE_SECTIONS, "lists", "expansion_rules", "skip_words"}:
        raise error_at(
            text.place(text.root),
            'expected "intents" (hassil) or "context" (Rhino)',
        )
    return parse_hassil(text)


def _keywords(data: bytes, name: str, path: Path, read: dict[Path, bytes]) -> TemplateSource:
    """Parse a keyword list of pocketsphinx: what is said, then its threshold, as /1e-20/."""
    source = parse_templates(_THRESHOLD.sub(b"", data), name)
    return replace(source, advice=Advice(sentence="write one keyphrase per line, as: stop /1e-20/"))


_THRESHOLD = re.compile(rb"[ \t]*/[0-9.]+([eE][-+]?[0-9]*)?/[ \t]*\r?$", re.MULTILINE)
"""Keyword lists are also called `.list` or `.txt`."""


def _jsgf(data: bytes, name: str, path: Path, read: dict[Path, bytes]) -> TemplateSource:
    from voz.language.formats.jsgf import parse_jsgf

    return parse_jsgf(data, name)


FormatParser: TypeAlias = Callable[[bytes, str, Path, dict[Path, bytes]], TemplateSource]
"""Parses data called name; the path and the read files are for imported files."""

PARSERS: Mapping[str, FormatParser] = {
    ".ini": _rhasspy,
    ".yaml": _yaml,
    ".yml": _yaml,
    ".gram": _jsgf,
    ".jsgf": _jsgf,
    ".kwlist": _keywords,
    ".kws": _keywords,
}
"""By the ending of the file; other files are in voz's own notation."""
