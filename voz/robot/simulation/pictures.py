"""Pictures and animations of what a simulated robot did, by matplotlib, which is imported late."""

from __future__ import annotations

import shutil
from pathlib import Path

from voz.errors import ConfigError
from voz.extras import require
from voz.files import check_writable, os_errors_as_config_error
from voz.robot.simulation.simulator import Trip

PICTURES = (".png", ".svg")
ANIMATIONS = (".gif", ".mp4")


def check_picture(path: Path) -> None:
    """Raise ConfigError, before the run, if a PNG or SVG of it cannot be written."""
    _check(path, PICTURES, "a picture")


def check_animation(path: Path) -> None:
    """Raise ConfigError, before the run, if a GIF or MP4 of it cannot be written."""
    _check(path, ANIMATIONS, "an animation")
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise ConfigError(
            f"{path}: needs ffmpeg; run `sudo apt-get install ffmpeg`, or end it with .gif"
        )


def save_picture(trip: Trip, path: Path) -> None:
    """Draw the room, the robot's way and what was said where; raises ConfigError."""
    check_picture(path)
    from voz.robot.simulation.scene import write_picture

    with os_errors_as_config_error(path):
        write_picture(trip, path)


def save_animation(trip: Trip, path: Path) -> None:
    """Draw the same as it happened, at real speed; raises ConfigError."""
    check_animation(path)
    from voz.robot.simulation.scene import write_animation

    with os_errors_as_config_error(path):
        write_animation(trip, path)


def _check(path: Path, endings: tuple[str, str], what: str) -> None:
    if path.suffix.lower() not in endings:
        raise ConfigError(f"{path}: not a file name for {what}; end it with {' or '.join(endings)}")
    require("report", "matplotlib")
    check_writable(path)
