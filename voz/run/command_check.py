"""Checks of a list of commands against the table of what they do."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from voz.config import Config
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


def mismatches(commands: Commands, settings: Config, code_of_its_own: bool) -> Iterator[str]:
    """Yield a line for each part of a list and of the settings that does not fit the other.

    A robot with code of its own may act on commands that the table lacks.
    """
    table = settings.table
    idle = [name for name in commands.names if not any(name in own for own in table.sets.values())]
    if idle and not code_of_its_own:
        yield f"no line of [commands] in voz.toml says what to do at {_quoted(idle)}"
    defined = [name for own in (settings.commands, *settings.states.values()) for name in own]
    defined += [
        name
        for name in settings.recognition.never_missed
        if name not in table.stops and commands.parse(name) is None
    ]
    unsaid = missing_commands(commands, defined)
    accented = {name: other for name in unsaid if (other := _accented_form(commands, name))}
    for name, other in accented.items():
        yield f'[commands] has "{name}" and the list "{other}": write both with the same accents'
    if unsaid := [name for name in unsaid if name not in accented]:
        quoted = _quoted(unsaid)
        yield f"no line of the list of commands is {quoted}: add it, and run `voz build-lm`"


def missing_commands(commands: Commands, named: Iterable[str]) -> list[str]:
    """Return the commands of a table that are missing from the list."""
    return [name for name in dict.fromkeys(named) if name not in commands.names]


def _accented_form(commands: Commands, name: str) -> str | None:
    """Return the command of a list that differs from a name only in accents, if there is one."""
    plain = strip_accents(name)
    return next((other for other in commands.names if strip_accents(other) == plain), None)


def _slots(commands: Commands, name: str) -> set[str]:
    parses = (commands.parse(text) for text in commands.named([name], MAX_SENTENCES_CHECKED))
    return {slot for parse in parses if parse for slot in parse.slots}


def _quoted(names: Sequence[str]) -> str:
    shown = " or ".join(f'"{name}"' for name in names[:2])
    return shown + (f" or {len(names) - 2} more" if len(names) > 2 else "")
