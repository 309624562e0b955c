"""Drives a ROS 2 robot by voice: `ros2 launch voz voz.launch.py`, `-s` lists the arguments.

It starts `voz run --robot ros2`, which needs no ROS, and ends everything when voz ends. It is the
program of the package `voz`, if that was built; without it, `ros2 launch ros/launch/voz.launch.py`
starts the `voz` that is found, or the one that you name: `voz:=$HOME/voz/.venv/bin/voz`.
"""

from __future__ import annotations

import os
from pathlib import Path

OPTIONS = {
    "device": "number of the microphone, or a part of its name",
    "lm": "folder of the language files",
    "profile": "who speaks, as `voz calibrate` knows them",
    "config": "voz.toml: topics, namespace, TwistStamped, limits",
    "events": "file to which all events are written",
}
SWITCHES = {
    "no-sound": "true: do not speak",
    "listening": "true: obey without `start speech`",
}


def program() -> str:
    """The program of the package that this file is installed with; else the first `voz` there is.

    Installed, this file is PREFIX/share/voz/launch/voz.launch.py.
    """
    beside = Path(__file__).absolute().parents[3] / "lib" / "voz" / "voz"
    return str(beside) if beside.is_file() else "voz"


def command(arguments: dict[str, str]) -> list[str]:
    """What is started.

    Args:
        arguments: those of the launch file; one that is empty is left out.
    """
    # Else the settings would be those of the folder that `ros2 launch` is called in.
    arguments = arguments | {"config": arguments.get("config") or os.devnull}
    chosen = [f"--{name}={arguments[name]}" for name in OPTIONS if arguments.get(name)]
    switched = [f"--{name}" for name in SWITCHES if arguments.get(name) == "true"]
    return [arguments["voz"], "run", "--robot", "ros2", *chosen, *switched]


def generate_launch_description():
    """What `ros2 launch` asks for."""
    from launch import LaunchDescription
    from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
    from launch.substitutions import LaunchConfiguration

    def start(context, *_):
        names = ["voz", *OPTIONS, *SWITCHES]
        arguments = {name: LaunchConfiguration(name).perform(context) for name in names}
        return [ExecuteProcess(cmd=command(arguments), output="screen", on_exit=Shutdown())]

    return LaunchDescription(
        [
            DeclareLaunchArgument("voz", default_value=program(), description="the program"),
            *(
                DeclareLaunchArgument(name, default_value="", description=description)
                for name, description in (OPTIONS | SWITCHES).items()
            ),
            OpaqueFunction(function=start),
        ]
    )
