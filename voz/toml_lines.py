"""Finds the lines of a voz.toml on which commands are defined; no TOML parser reports them."""

from __future__ import annotations

import re

from voz.control.table import DEFAULT_STATE

KEY = re.compile(r"""\s*(?:"([^"]*)"|'([^']*)'|([\w-]+))\s*(\.?)""")
"""A key at the beginning of a line, and whether another follows."""


def lines_of_commands(text: str) -> dict[tuple[str, str], int]:
    """Find the line of each command, by its state and name, however its table is written.

    The text is valid TOML; keys with escapes are not found.
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
    """Split the keys at the beginning of a line, as `states.menu."go back"`."""
    keys: list[str] = []
    at = 0
    while found := KEY.match(line, at):
        keys.append(found[1] or found[2] or found[3] or "")
        at = found.end()
        if not found[4]:
            break
    return tuple(keys)
