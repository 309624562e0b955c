"""`voz new`: begins a robot of one's own."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Annotated

import typer

from voz.cli.text_io import info, show

FILES_ARE = {
    "commands.txt": "what may be said",
    "voz.toml": "what the commands do, and the settings",
    "my_robot.py": "the robot",
    "test_my_robot.py": "its test",
}


def new(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Where; a new one.")],
    robot_type: Annotated[
        str,
        typer.Option("--type", metavar="python|serial|ros1|ros2", help="How it is driven."),
    ] = "python",
) -> None:
    """Begin a robot of your own: a folder in which `voz run` works at once.

    It has a list of commands, a voz.toml, a test, and the class of a robot that prints what its
    motors should do (`python`) or writes it to a serial port (`serial`); with ROS the robot is
    voz's own.

    Example: voz new robot
    """
    from voz.apps.starter.robot_folder import make_robot_folder
    from voz.files import shown_path

    for path in make_robot_folder(folder, robot_type):
        show(f"{shown_path(path)}: {FILES_ARE[path.name]}")
    info(f"go on with: cd -- {shlex.quote(shown_path(folder))}; voz run")
