"""Drives a ROS 2 robot by voice: `ros2 launch ros/launch/voz.launch.py`, `-s` lists the arguments.

It starts `voz run --robot ros2`, which needs no ROS, and ends everything when voz ends. voz may
stand in a virtual environment of its own: `voz:=$HOME/voz/.venv/bin/voz`.
"""

from __future__ import annotations

import os

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
            DeclareLaunchArgument("voz", default_value="voz", description="the program"),
            *(
                DeclareLaunchArgument(name, default_value="", description=description)
                for name, description in (OPTIONS | SWITCHES).items()
            ),
            OpaqueFunction(function=start),
        ]
    )
