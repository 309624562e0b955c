"""Offline voice control for robots: speak a command, the robot moves and answers.

    import voz

    recognizer = voz.load()
    for utterance in recognizer.decode(array, rate=44100):
        print(utterance.text, utterance.accepted)

Everything here is loaded when it is first used; to import voz itself takes no time and changes
nothing in the process.
"""

from importlib import import_module
from typing import TYPE_CHECKING
from warnings import warn

from voz.errors import (
    AudioError,
    CommandsError,
    ConfigError,
    LanguageError,
    RecognizerBusyError,
    RobotError,
    RobotMistake,
    ServiceError,
    SpeechError,
    VozError,
)

if TYPE_CHECKING:
    from voz.api.load import load
    from voz.api.recognizer import Listener, Recognizer
    from voz.apps.batch.batch_decoder import Decoded, decode_many
    from voz.apps.batch.formats import read_results
    from voz.apps.web.client import Client
    from voz.config import Config, load_config
    from voz.events import (
        Alternative,
        Attention,
        CallFunction,
        Event,
        Notice,
        Partial,
        Play,
        PossibleCommand,
        ProgramEnded,
        Publish,
        Reply,
        SelectedObject,
        SpokenWord,
        StartProgram,
        Twist,
        Utterance,
    )
    from voz.robot.base import Robot
    from voz.run.controller import Controller
    from voz.settings import Recognition, Safety
    from voz.speech.builtin_sounds import BuiltinSound
    from voz.speech.sound_client import SoundClient

__version__ = "0.1.0"

_WHERE = {
    "Alternative": "voz.events",
    "Attention": "voz.events",
    "BuiltinSound": "voz.speech.builtin_sounds",
    "CallFunction": "voz.events",
    "Client": "voz.apps.web.client",
    "Config": "voz.config",
    "Controller": "voz.run.controller",
    "Decoded": "voz.apps.batch.batch_decoder",
    "ProgramEnded": "voz.events",
    "Event": "voz.events",
    "Listener": "voz.api.recognizer",
    "Partial": "voz.events",
    "Play": "voz.events",
    "PossibleCommand": "voz.events",
    "Publish": "voz.events",
    "Recognition": "voz.settings",
    "Recognizer": "voz.api.recognizer",
    "Reply": "voz.events",
    "Robot": "voz.robot.base",
    "StartProgram": "voz.events",
    "Safety": "voz.settings",
    "SelectedObject": "voz.events",
    "SoundClient": "voz.speech.sound_client",
    "SpokenWord": "voz.events",
    "Twist": "voz.events",
    "Utterance": "voz.events",
    "Notice": "voz.events",
    "decode_many": "voz.apps.batch.batch_decoder",
    "load": "voz.api.load",
    "load_config": "voz.config",
    "read_results": "voz.apps.batch.formats",
}

__all__ = [
    "Alternative",
    "Attention",
    "AudioError",
    "BuiltinSound",
    "CallFunction",
    "Client",
    "CommandsError",
    "Config",
    "ConfigError",
    "Controller",
    "Decoded",
    "Event",
    "LanguageError",
    "Listener",
    "Notice",
    "Partial",
    "Play",
    "PossibleCommand",
    "ProgramEnded",
    "Publish",
    "Recognition",
    "Recognizer",
    "RecognizerBusyError",
    "Reply",
    "Robot",
    "RobotError",
    "RobotMistake",
    "Safety",
    "SelectedObject",
    "ServiceError",
    "SoundClient",
    "SpeechError",
    "SpokenWord",
    "StartProgram",
    "Twist",
    "Utterance",
    "VozError",
    "__version__",
    "decode_many",
    "load",
    "load_config",
    "read_results",
]


if not TYPE_CHECKING:  # for which every name would be there

    def __getattr__(name: str) -> object:
        if name == "Warning":
            warn("voz.Warning is called voz.Notice", DeprecationWarning, stacklevel=2)
            return __getattr__("Notice")
        if name not in _WHERE:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        found = globals()[name] = getattr(import_module(_WHERE[name]), name)
        return found


def __dir__() -> list[str]:
    return sorted(__all__)
