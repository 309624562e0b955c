"""Messages that voz defines itself: on `trouble`, and sound_play's on `robotsound`.

Debian does not have the package sound_play. Its message is generated here from the same fields and
constants (http://wiki.ros.org/sound_play): ROS compares the MD5 of those, and finds the same.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

from voz.audio.microphone import ONLY_SILENCE


@dataclass(frozen=True)
class RecognizerStatus:
    """Whether a recognizer hears."""

    problem: str = ""  # why it hears nothing; empty if all is well
    # Whether its microphone gives only zeros, which matters to a moving robot.
    only_silence: bool = False

    @property
    def text(self) -> str:
        """The message; another recognizer may publish any other text as a problem."""
        return self.problem or (ONLY_SILENCE if self.only_silence else "")


def parse_status(text: str) -> RecognizerStatus:
    """Read a message."""
    silent = text == ONLY_SILENCE
    return RecognizerStatus("" if silent else text, silent)


TOPIC = "robotsound"

ALL, PLAY_FILE, SAY = -1, -2, -3
"""What is played, besides the built-in sounds by their numbers."""

STOP, ONCE, START = 0, 1, 2
"""What is done with it; `START` repeats it until it is stopped."""

DEFINITION = """\
int8 BACKINGUP = 1
int8 NEEDS_UNPLUGGING = 2
int8 NEEDS_PLUGGING = 3
int8 NEEDS_UNPLUGGING_BADLY = 4
int8 NEEDS_PLUGGING_BADLY = 5
int8 ALL = -1
int8 PLAY_FILE = -2
int8 SAY = -3
int8 sound
int8 PLAY_STOP = 0
int8 PLAY_ONCE = 1
int8 PLAY_START = 2
int8 command
float32 volume
string arg
string arg2
"""


@functools.cache
def sound_request() -> Any:
    """Return the class of the message: sound, command, volume (0 to 1), arg and arg2."""
    from genpy.dynamic import generate_dynamic

    name = "sound_play/SoundRequest"
    return generate_dynamic(name, DEFINITION)[name]
