"""Offline voice control for robots: speak a command, the robot moves and answers."""

import os

# Matrices here are small: several threads of numpy's wait for each other, and burn twice the CPU.
# Set before numpy is imported; whoever wants it otherwise has set it already.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from voz.errors import (
    AudioError,
    CommandsError,
    ConfigError,
    LanguageError,
    RobotError,
    RobotMistake,
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
    "RobotMistake",
    "SpeechError",
    "VozError",
    "__version__",
]
