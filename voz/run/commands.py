"""Whether a list of commands and the table of what they do fit each other."""

from __future__ import annotations

from collections.abc import Iterable

from voz.control.steps import Step
from voz.control.table import CommandTable, check_commands
from voz.errors import ConfigError
from voz.language.templates.commands import Commands

MOST_LOOKED_AT = 64
"""Sentences of a command that are looked at."""


def check_list(commands: Commands, table: CommandTable, where: str) -> None:
    """Refuse a list that could set a robot going and not stop it.

    Args:
        commands: the list.
        table: what the commands do.
        where: what messages call the list.

    Raises:
        ConfigError: so it is.
    """
    for _, name, step in table.all_steps():
        if name in commands.names and step.slots:
            _check_slots(commands, name, step, where)
    stops = commands.named(table.stops, MOST_LOOKED_AT)
    after = {name for stop in stops for name in commands.going_on(stop)}
    check_commands(table, commands.names, after, where)


def begins_listening(commands: Commands, table: CommandTable) -> bool:
    """Tell whether a list has a command that begins the listening."""
    return not table.starts.isdisjoint(commands.names)


def idle(commands: Commands, table: CommandTable) -> list[str]:
    """Name the commands of a list that do nothing, in any state."""
    return [name for name in commands.names if not any(name in own for own in table.sets.values())]


def never_said(commands: Commands, named: Iterable[str]) -> list[str]:
    """Name the commands of a table that a list does not have: nobody can say them."""
    return [name for name in dict.fromkeys(named) if name not in commands.names]


def _check_slots(commands: Commands, name: str, step: Step, where: str) -> None:
    """Refuse a step with a slot that its command has in no sentence."""
    parses = (commands.parse(text) for text in commands.named([name], MOST_LOOKED_AT))
    known = {slot for parse in parses if parse for slot in parse.slots}
    if missing := step.slots - known:
        have = f"it has {', '.join(sorted(known))}" if known else "it has none"
        raise ConfigError(
            f'[commands] "{name}" uses the slot {min(missing)}, which {where} does not give it; '
            f"{have}"
        )
