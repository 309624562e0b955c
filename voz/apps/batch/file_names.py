"""Names of the files that are written for each recording."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from voz.files import check_new, sha256

LONGEST_FILE_NAME = 200
"""Bytes; file systems take 255, with endings."""

EVENTS_ENDING = ".jsonl"
"""Of the events of a simulated run."""

FOLDER_SEPARATOR = "+"
"""Stands in names of files for the `/` between folders."""

ESCAPED_CHARACTERS = frozenset(r'%+\:*?"<>|')
"""What file systems refuse or programs take for something else, and what stands for others."""


def file_name_for(name: str) -> str:
    """Make a unique file name of a path or an address: `rooms+kitchen+1.wav`."""
    escaped = "".join(map(_in_file_name, name))
    if escaped.startswith("."):  # else it would be hidden, or lead elsewhere
        escaped = _escaped(".") + escaped[1:]
    encoded = escaped.encode()
    if len(encoded) <= LONGEST_FILE_NAME:
        return escaped
    end = encoded[-LONGEST_FILE_NAME // 2 :].decode(errors="ignore")
    return f"{sha256(encoded).hexdigest()[:16]}-{end}"


def _in_file_name(character: str) -> str:
    if character == "/":
        return FOLDER_SEPARATOR
    if character.isprintable() and character not in ESCAPED_CHARACTERS:
        return character
    return _escaped(character)


def _escaped(text: str) -> str:
    return "".join(f"%{byte:02X}" for byte in text.encode("utf-8", "surrogateescape"))


def check_none_there(folder: Path, names: Iterable[str], ending: str) -> None:
    """Refuse to replace files of an earlier run; raises ConfigError.

    Args:
        folder: where the files are.
        names: the recordings, as results name them.
        ending: of the files.
    """
    for name in names:
        check_new(folder / (file_name_for(name) + ending), overwrite=False)
