"""Checks of a list of commands against the table of what they do."""

from __future__ import annotations

from collections.abc import Iterable

from voz.control.table import CommandTable, check_commands
from voz.language.sentences.command_set import Commands
from voz.language.sentences.spelling import strip_accents

MAX_SENTENCES_CHECKED = 64
"""Sentences of a command that are checked."""


def check_list(commands: Commands, table: CommandTable, where: str) -> None:
    """Raise ConfigError for a list, called `where`, that can move the robot and not stop it."""
    for state, name, step in table.all_steps():
        if name in commands.names and step.slots:
            known = _slots(commands, name)
            if missing := step.slots - known:
                have = f"it has {', '.join(sorted(known))}" if known else "it has none"
                why = f"uses the slot {min(missing)}, which {where} does not give it; {have}"
                raise table.error_at(state, name, why)
    stops = commands.named(table.stops, MAX_SENTENCES_CHECKED)
    after = {name for stop in stops for name in commands.continuing_commands(stop)}
    check_commands(table, commands.names, after, where)


def begins_listening(commands: Commands, table: CommandTable) -> bool:
    """Return whether a list has a command that begins the listening."""
    return not table.starts.isdisjoint(commands.names)


def commands_without_effect(commands: Commands, table: CommandTable) -> list[str]:
    """Return the commands of a list that do nothing in any state."""
    return [name for name in commands.names if not any(name in own for own in table.sets.values())]


def missing_commands(commands: Commands, named: Iterable[str]) -> list[str]:
    """Return the commands of a table that are missing from the list."""
    return [name for name in dict.fromkeys(named) if name not in commands.names]


def accented_form(commands: Commands, name: str) -> str | None:
    """Return the command of a list that differs from a name only in accents, if there is one."""
    plain = strip_accents(name)
    return next((other for other in commands.names if strip_accents(other) == plain), None)


def _slots(commands: Commands, name: str) -> set[str]:
    parses = (commands.parse(text) for text in commands.named([name], MAX_SENTENCES_CHECKED))
    return {slot for parse in parses if parse for slot in parse.slots}
