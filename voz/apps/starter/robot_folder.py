"""Makes a folder with a robot of one's own that works at once. Does I/O."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from voz.errors import ConfigError
from voz.files import os_errors_as_config_error, shown_path
from voz.language.build import build

TEMPLATES = Path(__file__).with_name("templates")

CODE_SUFFIX = ".py.txt"
"""Of Python files there, so that no tool takes them for voz's own."""

ROBOT_TYPES = {
    "python": ("all", "python"),
    "serial": ("all", "serial"),
    "ros1": ("all", "ros", "ros1"),
    "ros2": ("all", "ros", "ros2"),
}
"""The folders of templates that each type is made of."""

COMMANDS, LANGUAGE = "commands.txt", "lm"


def make_robot_folder(folder: Path, robot_type: str) -> list[Path]:
    """Make a new folder with a list of commands, settings, a robot of a type and its test.

    Returns the files that may be edited.

    Raises:
        ConfigError: there is no such type, or the folder cannot be made or is not empty.
    """
    if robot_type not in ROBOT_TYPES:
        raise ConfigError(f"--type {robot_type}: give one of {', '.join(ROBOT_TYPES)}")
    with os_errors_as_config_error(folder):
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise ConfigError(f"{shown_path(folder)}: is not empty; name a new folder")
        made = [folder / name for name, _ in _files(robot_type)]
        for path, (_, text) in zip(made, _files(robot_type), strict=True):
            path.write_text(text, encoding="utf-8")
    build(folder / COMMANDS, folder / LANGUAGE)
    return made


def _files(robot_type: str) -> Iterator[tuple[str, str]]:
    """Yield name and text of each file."""
    for part in ROBOT_TYPES[robot_type]:
        for path in sorted((TEMPLATES / part).iterdir()):
            yield path.name.replace(CODE_SUFFIX, ".py"), path.read_text(encoding="utf-8")
