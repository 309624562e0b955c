"""Finds what must not be missed while the robot speaks, in sound cleaned of its echo."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE
from voz.audio.echo import Cleaned
from voz.audio.sound_files import to_int16
from voz.events import Utterance
from voz.recognition.interpreter import Interpreter
from voz.recognition.spotting import SpottedCommand

PLAYBACK_SECONDS = 1.4
"""Of a look: several looks hear a word whole."""

PLAYBACK_WINDOW = int(PLAYBACK_SECONDS * SAMPLE_RATE)

LOOKS = 4
"""A command must be found in some of so many looks."""

SAME_PLACE = 0.1
"""Two looks find the same word if its ends are closer than this, s."""

MIN_SCORES = {2: 6.0, 3: 4.5}
"""Least mean score, nats, of a command that so many looks find."""


class Limits(NamedTuple):
    """What a command needs that is said while the robot speaks.

    Attributes:
        score: least score without the phones of the reply, nats.
        level: least level above the usual residue of the echo, dB.
    """

    score: float
    level: float


STOP_LIMITS = Limits(6.0, 0.0)
COMMAND_LIMITS = Limits(8.0, 3.0)

MARGIN = 0.25
"""Sound around it that is listened to as well, s."""


class PlaybackSpotter:
    """Looks again and again at the last of one stream; a command counts if several looks find it.

    What is left of the robot's words changes with each window in which they are fitted; what
    somebody says stays.
    """

    def __init__(self, interpreter: Interpreter, source: str) -> None:
        self._interpreter = interpreter
        self._source = source
        self._looks: list[SpottedCommand] = []  # the last ones, in the time of the stream

    @property
    def works(self) -> bool:
        """Whether there is a network, by which it finds commands."""
        return self._interpreter.spots

    def look(self, sound: Cleaned, now: float) -> Utterance | None:
        """Return a command that must not be missed, if it was said.

        Args:
            sound: the last `PLAYBACK_WINDOW` samples.
            now: where they end in the stream, s.
        """
        found = self._interpreter.look(sound)
        if found is None:
            return None
        if sound.level_above_residue(found.begin, found.end) < STOP_LIMITS.level:
            return None
        look = found.moved(now - len(sound.samples) / SAMPLE_RATE)
        before = [other for other in self._looks if other.end > now - PLAYBACK_SECONDS]
        self._looks = [*before, look][-LOOKS:]
        alike = [
            other.score
            for other in before
            if other.text == look.text and abs(other.end - look.end) < SAME_PLACE
        ]
        if not _is_enough(look.score, sorted(alike, reverse=True)):
            return None
        self._looks = []
        return self._interpreter.spotted(look, now, self._source)

    def is_said(self, text: str, sound: Cleaned, begin: float, end: float, limits: Limits) -> bool:
        """Whether a command is no echo: it stands out of the echo, and has phones of its own.

        Args:
            text: the command.
            sound: as much as there is around it.
            begin: where it begins, s.
            end: where it ends, s.
            limits: what it needs.
        """
        first = begin - MARGIN
        if begin < 0 or first * SAMPLE_RATE > len(sound.samples):
            return False
        first = max(0.0, first)
        part = sound.cut(slice(round(first * SAMPLE_RATE), round((end + MARGIN) * SAMPLE_RATE)))
        found = self._interpreter.look(part, text)
        if found is None:
            return True
        level = sound.level_above_residue(first + found.begin, first + found.end)
        return found.score > limits.score and level > limits.level

    def may_be_echo(self, text: str, played: npt.NDArray[np.float32]) -> bool:
        """Whether a command may be among the words of what was played, 16 kHz, -1 to 1."""
        return self._interpreter.is_within(to_int16(played), text)


def _is_enough(score: float, others: list[float]) -> bool:
    means = {
        count: (score + sum(others[: count - 1])) / count
        for count in MIN_SCORES
        if len(others) >= count - 1
    }
    return any(mean > MIN_SCORES[count] for count, mean in means.items())
