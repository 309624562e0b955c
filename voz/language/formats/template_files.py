"""Reads a file of templates and those that it imports, in any format. Does I/O."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeAlias

from voz.errors import CommandsError
from voz.files import read_bytes, shown_path
from voz.language.formats.template_list import has_templates, parse_templates
from voz.language.formats.text_lines import MAX_TEXT_BYTES
from voz.language.sentences.location import error_at
from voz.language.sentences.template_source import TemplateSource

MAX_IMPORTED_FILES = 100


def has_known_ending(path: Path) -> bool:
    """Whether the file is in the format of another program, by its ending."""
    return path.suffix.lower() in PARSERS


def is_templates(path: Path, data: bytes) -> bool:
    """Whether a file has more than plain sentences."""
    return has_known_ending(path) or has_templates(data)


def read_templates(path: Path) -> tuple[TemplateSource, dict[Path, bytes]]:
    """Read templates with their imports; return them, and the bytes of each file."""
    read: dict[Path, bytes] = {}
    source = _read(path, read)
    return source, read


def _read(path: Path, read: dict[Path, bytes]) -> TemplateSource:
    data = read[path] = read_bytes(path, CommandsError, "give a readable text file", MAX_TEXT_BYTES)
    parse = PARSERS.get(path.suffix.lower(), _sentences)
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
        file = path.parent / "slots" / named
        if ".." in file.parts or not file.is_file():
            return None
        data = read[file] = read_bytes(
            file, CommandsError, "give a readable text file", MAX_TEXT_BYTES
        )
        return shown_path(file), data

    return parse_rhasspy(data, name, slots)


def _yaml(data: bytes, name: str, path: Path, read: dict[Path, bytes]) -> TemplateSource:
    from voz.language.formats.hassil import SENTENCE_SECTIONS, parse_hassil
    from voz.language.formats.rhino import parse_rhino
    from voz.language.formats.yaml_text import Yaml

    text = Yaml(data, name)
    parts = text.mapping(text.root, "intents (of hassil) or a context (of Rhino)")
    if "context" in parts:
        return parse_rhino(text)
    if not parts.keys() & {*SENTENCE_SECTIONS, "lists", "expansion_rules"}:
        raise error_at(
            text.place(text.root),
            'expected "intents" (hassil) or "context" (Rhino)',
        )
    return parse_hassil(text)


def _jsgf(data: bytes, name: str, path: Path, read: dict[Path, bytes]) -> TemplateSource:
    from voz.language.formats.jsgf_parser import parse_jsgf

    return parse_jsgf(data, name)


FormatParser: TypeAlias = Callable[[bytes, str, Path, dict[Path, bytes]], TemplateSource]
"""Parses data called name; the path and the read files are for imported files."""

PARSERS: Mapping[str, FormatParser] = {
    ".ini": _rhasspy,
    ".yaml": _yaml,
    ".yml": _yaml,
    ".gram": _jsgf,
    ".jsgf": _jsgf,
}
"""By the ending of the file; other files are in voz's own notation."""
