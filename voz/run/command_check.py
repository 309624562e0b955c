"""Whether a list of commands goes with the table of what they do, at the start and when renewed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from voz.config import Config, command_names, defined_names, with_examples, with_names
from voz.control.table import HELP, CommandTable, check_commands
from voz.errors import CommandsError, ConfigError
from voz.files import read_bytes, shown_path
from voz.language.build import build
from voz.language.command_source import CommandSource, read_list
from voz.language.formats.command_list import (
    BESIDE_THE_LIST,
    EXPECTED_SENTENCES_FILE,
    failed_expectations,
    folder_of,
)
from voz.language.language_files import LanguageFiles, list_sources, stale_warning
from voz.language.sentences.command_set import Commands
from voz.language.spoken_language import configured_language
from voz.robot.factory import robot_names

MAX_SENTENCES_CHECKED = 64
"""Sentences of a command that are checked."""

MAX_NAMES = 4
"""Names of commands that a message lists."""

ROS_ROBOTS = ("ros1", "ros2")
"""Their topics are made at the start."""


def matched_settings(settings: Config, commands: Commands) -> Config:
    """Return settings with the names of a list's commands, and a sentence of each.

    Those in voz.toml may have other capitals or spaces, or lack accents, as in typed text. Raises
    ConfigError if a command is there twice.
    """
    found = {name: commands.find_name(name) for name in sorted(command_names(settings))}
    matched = with_names(settings, {name: other for name, other in found.items() if other})
    return with_examples(matched, commands.examples_by_name)


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


def check_beginning(commands: Commands, table: CommandTable, instead: str) -> None:
    """Raise ConfigError for a list of which nothing begins the listening; `instead` is advice."""
    if not begins_listening(commands, table):
        names = " or ".join(f'"{name}"' for name in sorted(table.starts))
        raise ConfigError(f"no command begins the listening; add {names}{instead}")


def mismatches(commands: Commands, settings: Config, code_of_its_own: bool) -> Iterator[str]:
    """Yield a line for each part of a list and of the settings that does not fit the other.

    A robot with code of its own may act on commands that the table lacks.
    """
    table = settings.table
    defined = defined_names(settings)
    yield from forgotten_alternatives(commands, settings)
    told = [names for names in commands.alternatives if not set(defined).isdisjoint(names)]
    known = {HELP}.union(*table.sets.values(), *told)
    idle = [name for name in commands.names if name not in known]
    if idle and not code_of_its_own:
        yield f"no line of [commands] in voz.toml says what to do at {_quoted(idle)}"
    defined += [
        name
        for name in settings.recognition.never_missed
        if name not in table.stops and commands.parse(name) is None
    ]
    if unsaid := missing_commands(commands, defined):
        quoted = _quoted(unsaid)
        yield f"no line of the list of commands is {quoted}: add it, and run `voz build-lm`"


def forgotten_alternatives(commands: Commands, settings: Config) -> Iterator[str]:
    """Yield a line for each template of which the settings have only some commands."""
    defined = defined_names(settings)
    known = {HELP}.union(*settings.table.sets.values())
    for names in commands.alternatives:
        done = [name for name in names if name in defined]
        if done and (idle := [name for name in names if name not in known]):
            yield (
                f"[commands] in voz.toml says what to do at {_quoted(done)}, and not at "
                f"{_quoted(idle)} of the same line: add it, or give the line a name"
            )


def missing_commands(commands: Commands, named: Iterable[str]) -> list[str]:
    """Return the commands of a table that are missing from the list."""
    return [name for name in dict.fromkeys(named) if name not in commands.names]


def _slots(commands: Commands, name: str) -> set[str]:
    parses = (commands.parse(text) for text in commands.named([name], MAX_SENTENCES_CHECKED))
    return {slot for parse in parses if parse for slot in parse.slots}


def _quoted(names: Sequence[str]) -> str:
    shown = " or ".join(f'"{name}"' for name in names[:2])
    return shown + (f" or {len(names) - 2} more" if len(names) > 2 else "")


def list_files(files: LanguageFiles) -> list[Path]:
    """Return the files that users write from which the language files are made, the list first.

    Those of a list that was deleted too, and what may be beside it.

    Raises:
        LanguageError: the language files cannot be used.
    """
    sources = list_sources(files) or [files.commands]
    return [*sources, *(folder_of(sources[0]) / name for name in BESIDE_THE_LIST)]


def read_list_again(files: LanguageFiles, settings: Config) -> CommandSource:
    """Read the list of language files; raises VozError if it cannot be used with the settings."""
    path = list_files(files)[0]
    source = read_list(path, configured_language(settings.language))
    settings = matched_settings(settings, source.commands)
    for wrong in wrong_expectations(source.commands, folder_of(path) / EXPECTED_SENTENCES_FILE):
        raise CommandsError(wrong)
    check_list(source.commands, settings.table, str(path))
    return source


def wrong_expectations(commands: Commands, path: Path) -> Iterator[str]:
    """Yield the failed expectations of a file, if it is there; raises CommandsError."""
    if path.is_file():
        data = read_bytes(path, CommandsError, "give a readable text file")
        yield from failed_expectations(commands, data, str(path))


def build_stale_files(files: LanguageFiles, settings: Config) -> str | None:
    """Make language files again whose list has changed; returns a line for the user, or None.

    Raises:
        VozError: the list cannot be used; the files stay as they were.
    """
    if stale_warning(files) is None or not list_sources(files):
        return None
    source = read_list_again(files, settings)
    build(Path(source.name), files.folder, source)
    return f"{source.name} has changed: made {shown_path(files.folder)} again"


def check_renewal(old: Config, new: Config, before: Commands, after: Commands) -> None:
    """Raise ConfigError for commands that a run can take only at its start.

    What stops the robot is known to the microphone, the inbox and the keyboard, and a robot in ROS
    has its topics.
    """
    for what, known, now in (
        ("stops the robot", old.table.halts, new.table.halts),
        ("begins the listening", old.table.starts, new.table.starts),
    ):
        if others := known ^ now:
            raise ConfigError(f'"{min(others)}" {what}, or did: start voz again to take that')
    topics = new.table.topics.items() - old.table.topics.items()
    if topics and not set(ROS_ROBOTS).isdisjoint(robot_names(old.robot)):
        raise ConfigError(f"{min(topics)[0]} is a new topic: start voz again to take it")
    if begins_listening(before, old.table):
        check_beginning(after, new.table, ", or start voz again")


def describe_renewal(old: Config, new: Config, before: Commands, after: Commands) -> str:
    """Say what has changed in what may be said, and in what is done."""
    added = [name for name in after.names if name not in before.names]
    gone = [name for name in before.names if name not in after.names]
    redone = [name for name in _redefined(old, new) if name not in added + gone]
    unsaid = missing_commands(after, [name for name in redone if name in new.commands])
    changed = [name for name in redone if name not in unsaid]
    named = (
        (f"new {_listed(added)}", added),
        (f"gone {_listed(gone)}", gone),
        (f"changed {_listed(changed)}", changed),
    )
    parts = [told for told, names in named if names]
    if unsaid:
        parts.append(f"no line of the list is {_listed(unsaid)}")
    parts = parts or [f"{len(after):,} sentences"]
    others = [name for name in Config.__struct_fields__ if name not in ("commands", "states")]
    if later := [name for name in others if getattr(old, name) != getattr(new, name)]:
        parts.append(f"from the next start: {', '.join(later)}")
    return f"the commands were renewed: {'; '.join(parts)}"


def _redefined(old: Config, new: Config) -> list[str]:
    """The names that have other steps, in any state."""
    before, after = (
        {(state, name): steps for state, own in sets.items() for name, steps in own.items()}
        for sets in ({"": old.commands, **old.states}, {"": new.commands, **new.states})
    )
    keys = {**before, **after}
    return list(dict.fromkeys(key[1] for key in keys if before.get(key) != after.get(key)))


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(f'"{name}"' for name in names[:MAX_NAMES])
    return shown + (f" and {len(names) - MAX_NAMES} more" if len(names) > MAX_NAMES else "")
