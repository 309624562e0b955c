"""One typed configuration, read from `voz.toml`; missing settings have their defaults."""

from __future__ import annotations

import logging
import re
import sys
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
from msgspec.structs import replace

from voz.control.steps import CommandDefinition, Step
from voz.control.table import DEFAULT_STATE, CommandTable, Places, command_table
from voz.errors import ConfigError
from voz.files import MAX_SETTINGS_BYTES, read_text
from voz.language.sentences.spelling import plain_form
from voz.records import PublicNames, check_path
from voz.settings import (
    Recognition,
    Recording,
    Ros1,
    Ros2,
    Safety,
    Section,
    Simulator,
    Speech,
    SpokenLanguage,
)
from voz.texts import language_of, text

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


_log = logging.getLogger("voz")


class Config(PublicNames, Section, frozen=True, kw_only=True, dict=True):
    """All settings.

    Attributes:
        lm: folder of the language files; None looks for `lm/` here, then in the package.
        robot: who receives the motion, by the names in `voz.robot.factory`.
        language: what is spoken.
        recognition: how commands are recognized.
        safety: the safety rules.
        speech: what the robot says.
        recording: what is kept of what is heard.
        simulator: the simulated robot and its room.
        ros1: the robot of ROS 1.
        ros2: the robot of ROS 2.
        own: settings of the user's own robots, by their modules: the arguments of their classes.
        commands: what each command does, beside or in place of what voz's own commands do.
        states: other sets of commands, by the name that the step `state` switches to.
    """

    lm: str | None = None
    robot: tuple[str, ...] = ("console",)
    language: SpokenLanguage = SpokenLanguage()
    recognition: Recognition = Recognition()
    safety: Safety = Safety()
    speech: Speech = Speech()
    recording: Recording = Recording()
    simulator: Simulator = Simulator()
    ros1: Ros1 = Ros1()
    ros2: Ros2 = Ros2()
    own: dict[str, dict[str, Any]] = msgspec.field(default_factory=dict)
    commands: dict[str, CommandDefinition] = msgspec.field(default_factory=dict)
    states: dict[str, dict[str, CommandDefinition]] = msgspec.field(default_factory=dict)

    def __post_init__(self) -> None:
        """Let replies in another language be said by its voice, if no other is named."""
        super().__post_init__()
        code = self.language.name
        if self.speech.voice == Speech().voice and re.fullmatch(_LANGUAGE_CODE, code):
            spoken = replace(self.speech, voice=f"espeak-ng:{code}")
            msgspec.structs.force_setattr(self, "speech", spoken)

    @property
    def table(self) -> CommandTable:
        """What each command does, voz's own too; ConfigError if the robot might not stop."""
        commands = {**_builtin_in(self.language.name), **self.commands}
        examples = self.__dict__.get("_examples")
        return command_table(commands, self.states, self.places, examples)

    @property
    def places(self) -> Places:
        """File and line of each command that the file defines."""
        places: Places = self.__dict__.get("_places_in_file", {})
        return places

    @property
    def old_names(self) -> tuple[str, ...]:
        """A line about each setting that the file calls by an old name."""
        lines: tuple[str, ...] = self.__dict__.get("_old_names", ())
        return lines


PATHS = (
    ("lm",),
    ("language", "acoustic_model"),
    ("language", "dictionary"),
    ("language", "pronunciations"),
    ("recognition", "network"),
    ("recognition", "confidence"),
)
"""The settings that are files or folders, besides those of commands."""

OLD_NAMES = {("recognition", "second_ear"): "use_network"}
"""What settings are called that were called otherwise, by their table and old name."""

_LANGUAGE_CODE = "(?!en$)[a-z]{2,3}(-[a-z0-9]{2,8})*"
"""The name of a language other than English that espeak-ng may speak."""

DEFAULT_COMMANDS_FILE = Path(__file__).parent / "control" / "commands.toml"
"""What voz's own commands do, as a user would write it."""


@cache
def default_commands() -> CommandTable:
    """Return what voz's own commands do."""
    return Config().table


@cache
def _builtin(language: str = "") -> dict[str, CommandDefinition]:
    """What voz's own commands do: the English ones, and those of a language of which it has any."""
    commands = _read(DEFAULT_COMMANDS_FILE).commands
    if not re.fullmatch(_LANGUAGE_CODE, language):
        return commands
    own = DEFAULT_COMMANDS_FILE.with_suffix(f".{language}.toml")
    return {**commands, **_read(own).commands} if own.is_file() else commands


@cache
def _builtin_in(language: str) -> dict[str, CommandDefinition]:
    """Return voz's own commands with their replies in a language."""
    return {
        name: replace(step, say=text(step.say, language_of(language)))
        if isinstance(step, Step) and step.say
        else step
        for name, step in _builtin(language).items()
    }


def never_missing_a_stop(config: Config) -> Config:
    """Add all commands that stop the robot to `never_missed`; raises ConfigError."""
    names = dict.fromkeys([*config.recognition.never_missed, *sorted(config.table.stops)])
    sure = replace(config, recognition=replace(config.recognition, never_missed=tuple(names)))
    return _from_the_same_file(sure, config)


def defined_names(config: Config) -> list[str]:
    """Return the commands that settings define, in their order; one of several states repeats."""
    return [name for own in (config.commands, *config.states.values()) for name in own]


def command_names(config: Config) -> set[str]:
    """Return all names of commands in settings: of those defined, and of those meant."""
    definitions = [config.commands, *config.states.values()]
    meant = [d for own in definitions for d in own.values() if isinstance(d, str)]
    return {*defined_names(config), *meant, *config.recognition.never_missed}


def with_usual_names(config: Config) -> Config:
    """Write voz's own commands, and those meant by an alias, as they are defined: in small letters.

    Raises:
        ConfigError: a command is there twice.
    """
    defined = set(defined_names(config))
    builtin = _builtin(config.language.name)
    usual = {plain_form(name): name for name in (*sorted(defined), *builtin)}
    others = {name: usual.get(plain_form(name)) for name in command_names(config)}
    return with_names(
        config,
        {
            name: other
            for name, other in others.items()
            if other and name != other and (other in builtin or name not in defined)
        },
    )


def with_examples(config: Config, examples: Mapping[str, str]) -> Config:
    """Return settings for a list with these sentences, one of each command by its name."""
    made = replace(config)
    made.__dict__.update(config.__dict__, _examples=examples)
    return made


def with_names(config: Config, names: Mapping[str, str]) -> Config:
    """Return settings whose commands have other names; ConfigError if two get the same one."""

    def named(definition: CommandDefinition) -> CommandDefinition:
        return names.get(definition, definition) if isinstance(definition, str) else definition

    def renamed(state: str, commands: Mapping[str, CommandDefinition]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for name, definition in commands.items():
            if (now := names.get(name, name)) in found:
                place = config.places.get((state, name), "voz.toml")
                raise ConfigError(f'{place}: "{name}" is "{now}", which is there twice; remove one')
            found[now] = named(definition)
        return found

    never_missed = tuple(names.get(name, name) for name in config.recognition.never_missed)
    made = replace(
        config,
        commands=renamed(DEFAULT_STATE, config.commands),
        states={state: renamed(state, own) for state, own in config.states.items()},
        recognition=replace(config.recognition, never_missed=never_missed),
    )
    places = {(state, names.get(n, n)): place for (state, n), place in config.places.items()}
    made.__dict__.update(config.__dict__, _places_in_file=places)
    return made


def load_config(path: Path) -> Config:
    """Read a TOML file with the tables and names of `Config`.

    Returns:
        The configuration; what the file does not name has its default.

    Raises:
        ConfigError: the file cannot be read or is no TOML, or a name, value or command is invalid.
    """
    config = _read(Path(check_path(path, "path")))
    config.table  # noqa: B018 (raises what is wrong with it)
    for line in config.old_names:
        _log.warning(line)
    return config


def _read(path: Path) -> Config:
    """Read a file without checking that its commands fit together."""
    text = read_text(path, ConfigError, "give an existing file, saved as UTF-8", MAX_SETTINGS_BYTES)
    try:
        settings = tomllib.loads(text)
        old_names = _rename(settings, path)
        _expand_home(settings, path)
        places = _check_commands(settings, text, path)
        config = msgspec.convert(settings, Config)
    except tomllib.TOMLDecodeError as error:
        there = _told_twice(text, str(error))
        raise ConfigError(f"{path}: is not valid TOML: {error}{there}") from error
    except ConfigError:  # which is a ValueError too
        raise
    except RecursionError:
        raise ConfigError(f"{path}: has too many tables in each other", "remove some") from None
    except msgspec.ValidationError as error:
        raise ConfigError(f"{path}: {error}", _advice(error)) from error
    except (ValueError, OverflowError):  # a number of more than 4300 digits
        raise ConfigError(f"{path}: has a number that is too long", "shorten it") from None
    config.__dict__.update(_places_in_file=places, _old_names=old_names)
    return config if path == DEFAULT_COMMANDS_FILE else with_usual_names(config)


def _rename(settings: dict[str, Any], path: Path) -> tuple[str, ...]:
    """Give settings the names of today; returns a line about each that had an old one."""
    lines = []
    for (table, old), new in OLD_NAMES.items():
        values = settings.get(table)
        if isinstance(values, dict) and old in values:
            values.setdefault(new, values.pop(old))
            lines.append(f"{path}: [{table}] {old} is called {new}")
    return tuple(lines)


def _expand_home(settings: dict[str, Any], path: Path) -> None:
    """Write `~` in all paths as the home folder, as a shell does."""
    for *table, name in PATHS:
        within = settings.get(table[0]) if table else settings
        if isinstance(within, dict) and isinstance(given := within.get(name), str):
            within[name] = _expanded(given, path)
    for step in _steps_of(settings):
        if isinstance(sound := step.get("play"), str):
            step["play"] = _expanded(sound, path)
        if isinstance(program := step.get("run"), list):
            step["run"] = [_expanded(w, path) if isinstance(w, str) else w for w in program]


def _expanded(text: str, path: Path) -> str:
    if text != "~" and not text.startswith("~/"):
        return text
    try:
        return str(Path(text).expanduser())
    except RuntimeError:
        raise ConfigError(f"{path}: {text}: there is no home folder", "write it out") from None


def _steps_of(settings: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the steps of all commands that a file defines, as they are in it."""
    states = settings.get("states")
    tables = [settings.get("commands"), *(states.values() if isinstance(states, dict) else ())]
    for commands in tables:
        for definition in commands.values() if isinstance(commands, dict) else ():
            steps = definition if isinstance(definition, list) else [definition]
            yield from (step for step in steps if isinstance(step, dict))


def _from_the_same_file(config: Config, other: Config) -> Config:
    config.__dict__.update(other.__dict__)
    return config


def _advice(error: msgspec.ValidationError) -> str:
    lists = "docs/settings.md lists the settings"
    at = re.search(r" - at `\$\.(\w+)", str(error))
    if at is None:
        return f"{_suggestion(error, Config)}{lists}; [own.MODULE] is for robots of your own"
    return f"{_suggestion(error, type(getattr(Config(), at[1])))}{lists}"


def _suggestion(error: msgspec.ValidationError, kind: type) -> str:
    unknown = re.search("unknown field `(.+?)`", str(error))
    fields = getattr(kind, "__struct_fields__", ())
    near = get_close_matches(unknown[1], fields, 1) if unknown else []
    return f"did you mean `{near[0]}`? " if near else ""


def _check_commands(settings: dict[str, Any], text: str, path: Path) -> Places:
    """Refuse an invalid command, with its name and line; return where each command stands."""
    states = settings.get("states", {})
    tables = {
        DEFAULT_STATE: settings.get("commands", {}),
        **(states if isinstance(states, dict) else {}),
    }
    lines = lines_of_commands(text)
    places: dict[tuple[str, str], str] = {}
    for state, commands in tables.items():
        table = f"states.{state}" if state else "commands"
        for name, command in commands.items() if isinstance(commands, dict) else ():
            line = f":{lines[state, name]}" if (state, name) in lines else ""
            places[state, name] = where = f"{path}{line}"
            try:
                msgspec.convert(command, CommandDefinition)
            except msgspec.ValidationError as error:
                why = str(error).partition(" - at `$`")[0]
                advice = _suggestion(error, Step) + "docs/actions.md lists what a command does"
                why += f"; {advice}" if "unknown field" in why else ""
                raise ConfigError(f'{where}: [{table}] "{name}": {why}') from error
    return places


def overridden(
    config: Config, options: dict[str, Any], kind: str = "an option", advice: str = "see --help"
) -> Config:
    """Return a configuration with options in place of its settings.

    Args:
        config: the settings that are not among the options.
        options: settings, and tables of settings, by their names; None changes nothing.
        kind: what messages call an option.
        advice: what messages say is to be done.

    Raises:
        ConfigError: a value is not allowed.
    """
    settings = msgspec.to_builtins(config)
    for name, value in options.items():
        if isinstance(value, dict):
            settings[name].update({key: v for key, v in value.items() if v is not None})
        elif value is not None:
            settings[name] = value
    try:
        made = msgspec.convert(settings, Config)
    except msgspec.ValidationError as error:
        raise ConfigError(f"{kind} cannot be used: {error}", advice) from error
    return never_missing_a_stop(_from_the_same_file(made, config))


KEY = re.compile(r"""\s*(?:"([^"]*)"|'([^']*)'|([\w-]+))\s*(\.?)""")
"""A key at the beginning of a line, and whether another follows."""


def lines_of_commands(text: str) -> dict[tuple[str, str], int]:
    """Find the line of each command, by its state and name, however its table is written.

    The text is valid TOML; keys with escapes are not found.
    """
    lines: dict[tuple[str, str], int] = {}
    for number, path in enumerate(_paths(text), start=1):
        if len(path) > 1 and path[0] == "commands":
            lines.setdefault((DEFAULT_STATE, path[1]), number)
        elif len(path) > 2 and path[0] == "states":
            lines.setdefault((path[1], path[2]), number)
    return lines


def _paths(text: str) -> Iterator[tuple[str, ...]]:
    """Yield the table and the key of each line; of a heading the table alone."""
    table: tuple[str, ...] = ()
    for line in text.split("\n"):
        begin = line.lstrip()
        if begin.startswith("["):
            table = _keys(begin.lstrip("["))
            yield table
        else:
            yield table + _keys(begin)


def _told_twice(text: str, error: str) -> str:
    """Say where a heading or key is already, which TOML refuses to have twice; else nothing."""
    paths = list(_paths(text))
    at = re.search(r"at line (\d+)", error)
    number = int(at[1]) if at else len(paths)
    path = paths[number - 1] if number <= len(paths) else ()
    if not path or path not in paths[: number - 1]:
        return ""
    first = paths.index(path) + 1
    if text.split("\n")[first - 1].lstrip().startswith("["):
        head = ".".join(path)
        return f"; [{head}] is in line {first} already: write what is new below that line"
    return f'; "{path[-1]}" is in line {first} already: remove one'


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
