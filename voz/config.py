"""One typed configuration, read from `voz.toml`; what the file leaves out keeps its default."""

from __future__ import annotations

import re
import sys
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
from msgspec.structs import replace

from voz.control.steps import CommandDefinition
from voz.control.table import CommandTable, command_table
from voz.errors import ConfigError
from voz.files import FEW_BYTES, read_text
from voz.settings import (
    Recognition,
    Recording,
    Ros1,
    Ros2,
    Safety,
    Section,
    Speech,
    SpokenLanguage,
)
from voz.simulation.settings import Simulator

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


class Config(Section, frozen=True, kw_only=True):
    """All settings.

    Attributes:
        lm: folder of the language files; None looks for `lm/` here, then in the package.
        robot: who receives the motion, by the names in `voz.robot.kinds`.
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

    @property
    def table(self) -> CommandTable:
        """What each command does, with those that voz brings.

        Raises:
            ConfigError: with it the robot might not stop, or it contradicts itself.
        """
        return command_table({**_brought(), **self.commands}, self.states)


USUAL_COMMANDS = Path(__file__).parent / "control" / "commands.toml"
"""What the commands do that voz brings, as a user would write it."""


@cache
def usual_commands() -> CommandTable:
    """What the commands do that voz brings."""
    return Config().table


@cache
def _brought() -> dict[str, CommandDefinition]:
    return load_config(USUAL_COMMANDS).commands


def never_missing_a_stop(config: Config) -> Config:
    """Let the commands that stop the robot be among those that are not missed.

    Raises:
        ConfigError: the table of commands cannot be used.
    """
    names = dict.fromkeys([*config.recognition.never_missed, *sorted(config.table.stops)])
    return replace(config, recognition=replace(config.recognition, never_missed=tuple(names)))


def load_config(path: Path) -> Config:
    """Read a configuration file.

    Args:
        path: a TOML file with the tables and names of `Config`.

    Returns:
        The configuration; what the file does not name has its default.

    Raises:
        ConfigError: the file cannot be read, is no TOML, or holds a wrong name or value.
    """
    text = read_text(path, ConfigError, "give an existing file, saved as UTF-8", FEW_BYTES)
    try:
        settings = tomllib.loads(text)
        _check_commands(settings, text, path)
        return msgspec.convert(settings, Config)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: is not valid TOML: {error}") from error
    except ConfigError:  # which is a ValueError too
        raise
    except RecursionError:
        raise ConfigError(f"{path}: has too many tables in each other; remove some") from None
    except msgspec.ValidationError as error:
        raise ConfigError(f"{path}: {error}; {_advice(error)}") from error
    except (ValueError, OverflowError):  # a number of more than 4300 digits
        raise ConfigError(f"{path}: has a number that is too long; shorten it") from None


def _advice(error: msgspec.ValidationError) -> str:
    """Say where a setting belongs; a table of no known name may be that of a user's own robot."""
    lists = "docs/settings.md lists the settings"
    return lists if " - at " in str(error) else f"{lists}; [own.MODULE] is for robots of your own"


def _check_commands(settings: dict[str, Any], text: str, path: Path) -> None:
    """Refuse a command that is wrong in itself; msgspec would leave out its name and line."""
    states = settings.get("states", {})
    tables = {"commands": settings.get("commands", {})}
    if isinstance(states, dict):
        tables |= {f"states.{name}": table for name, table in states.items()}
    for table, commands in tables.items():
        for name, command in commands.items() if isinstance(commands, dict) else ():
            try:
                msgspec.convert(command, CommandDefinition)
            except msgspec.ValidationError as error:
                why = str(error).partition(" - at `$`")[0]
                where = f"{path}{_line_of(name, text)}"
                raise ConfigError(f'{where}: [{table}] "{name}": {why}') from error


def _line_of(name: str, text: str) -> str:
    """Find where a command stands; empty if it is written in an unusual way."""
    quoted = rf"""["']?{re.escape(name)}["']?"""
    found = re.search(rf"^\s*({quoted}\s*[.=]|\[+[^\n]*{quoted}\s*\])", text, re.MULTILINE)
    return f":{text.count(chr(10), 0, found.end()) + 1}" if found else ""


def overridden(
    config: Config, options: dict[str, Any], kind: str = "an option", advice: str = "see --help"
) -> Config:
    """Put what was said on the command line in place of what the configuration has.

    Args:
        config: what holds otherwise.
        options: settings, and tables of settings, by their names; None changes nothing.
        kind: what messages call one of them.
        advice: what they say is to be done.

    Raises:
        ConfigError: a value cannot be.
    """
    settings = msgspec.to_builtins(config)
    for name, value in options.items():
        if isinstance(value, dict):
            settings[name].update({key: v for key, v in value.items() if v is not None})
        elif value is not None:
            settings[name] = value
    try:
        return never_missing_a_stop(msgspec.convert(settings, Config))
    except msgspec.ValidationError as error:
        raise ConfigError(f"{kind} cannot be used: {error}; {advice}") from error
