"""A node's private parameters, as a launch file or `_name:=value` sets them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from voz.config import Config, load_config, overridden
from voz.errors import ConfigError, RobotError
from voz.ros1.node import load_rospy

TRUE_WORDS, FALSE_WORDS = ("true", "1", "yes"), ("false", "0", "no")


def text(name: str) -> str | None:
    """Read a parameter as text; None if it is not set, or empty. Raises RobotError."""
    try:
        value = load_rospy().get_param(f"~{name}", "")
    except OSError as error:
        raise RobotError(f"the ROS master does not answer ({error}); is it running?") from error
    return str(value).strip() or None


def number(name: str) -> float | None:
    """Read a parameter that is a number; raises ConfigError if it is none."""
    value = text(name)
    try:
        return None if value is None else float(value)
    except ValueError:
        raise ConfigError(f"~{name}: {value} is not a number; correct the parameter") from None


def switch(name: str) -> bool | None:
    """Read a parameter that is true or false; raises ConfigError if it is neither."""
    value = text(name)
    if value is None or value.lower() in TRUE_WORDS + FALSE_WORDS:
        return None if value is None else value.lower() in TRUE_WORDS
    raise ConfigError(f"~{name}: {value} is neither true nor false; correct the parameter")


def choice(name: str, among: tuple[str, ...]) -> str:
    """Read a parameter that is one of some words; the first if it is not set."""
    value = text(name) or among[0]
    if value not in among:
        raise ConfigError(f"~{name}: {value} is none of {', '.join(among)}; correct the parameter")
    return value


def read_settings(**speech: Any) -> Config:
    """Read `~config`, a voz.toml, and put the parameters that have its names in their place.

    Args:
        speech: settings of how the robot answers.

    Raises:
        ConfigError: a value cannot be.
        RobotError: the master does not answer.
    """
    file = text("config")
    return overridden(
        load_config(Path(file)) if file else Config(),
        {
            "recognition": {"search": text("search"), "threshold": number("threshold")},
            "safety": {"enabled": switch("safety")},
            "speech": {"voice": text("voice"), **speech},
        },
        "a parameter of the node",
        "correct it",
    )
