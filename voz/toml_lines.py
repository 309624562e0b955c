"""In which lines of a voz.toml its commands stand: a parser of TOML does not tell. Pure."""

from __future__ import annotations

import re

from voz.control.table import DEFAULT_STATE

KEY = re.compile(r"""\s*(?:"([^"]*)"|'([^']*)'|([\w-]+))\s*(\.?)""")
"""One of the keys with which a line begins, and whether another follows."""


def lines_of_commands(text: str) -> dict[tuple[str, str], int]:
    """Find where each command is defined, however its table is written.

    Args:
        text: valid TOML.

    Returns:
        The first line of each, by its state and name; one that is written with escapes is left out.
    """
    lines: dict[tuple[str, str], int] = {}
    table: tuple[str, ...] = ()
    for number, line in enumerate(text.split("\n"), start=1):
        begin = line.lstrip()
        if begin.startswith("["):
            path = table = _keys(begin.lstrip("["))
        else:
            path = table + _keys(begin)
        if len(path) > 1 and path[0] == "commands":
            lines.setdefault((DEFAULT_STATE, path[1]), number)
        elif len(path) > 2 and path[0] == "states":
            lines.setdefault((path[1], path[2]), number)
    return lines


def _keys(line: str) -> tuple[str, ...]:
    """Read the keys with which a line begins, as `states.menu."go back"`."""
    keys: list[str] = []
    at = 0
    while found := KEY.match(line, at):
        keys.append(found[1] or found[2] or found[3] or "")
        at = found.end()
        if not found[4]:
            break
    return tuple(keys)
