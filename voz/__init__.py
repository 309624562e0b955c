"""Offline voice control for robots: speak a command, the robot moves and answers."""

from voz.errors import (
    AudioError,
    CommandsError,
    ConfigError,
    LanguageError,
    RobotError,
    SpeechError,
    VozError,
)

__version__ = "0.1.0"

__all__ = [
    "AudioError",
    "CommandsError",
    "ConfigError",
    "LanguageError",
    "RobotError",
    "SpeechError",
    "VozError",
    "__version__",
]
