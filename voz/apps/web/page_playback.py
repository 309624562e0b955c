"""What the driving page plays: a microphone near it must not take that for commands."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from voz.audio import SAMPLE_RATE
from voz.hearing.half_duplex import Playback

MAX_PLAYBACK = 30.0
"""The longest sound that a page may play, s: no recording is longer."""

PLAYBACK_DELAY = 1.0
"""A page may begin so much later than it says, s: wireless loudspeakers take a third of it."""


MAX_REPLIES = 4
"""Replies that are remembered: what they left in the room lasts for less."""


@dataclass(frozen=True, slots=True, eq=False)
class PageReply:
    """A reply that a page plays: its text, and its samples, 16 kHz, -1 to 1."""

    text: str
    sound: npt.NDArray[np.float32]


class PagePlayback:
    """The robot's own playback, and that of the driving page.

    Of a page's only the end is known, if it is no reply of the robot's. The server's thread calls
    `start`, the microphone's thread the others.

    Attributes:
        robot: the robot's own playback, if it has any.
    """

    def __init__(self) -> None:
        self.robot: Playback | None = None
        self._until = 0.0  # on the monotonic clock, s
        self._played: tuple[tuple[float, PageReply], ...] = ()  # with when they began, s
        self._is_reply = False  # what is played now

    def start(self, seconds: float, reply: PageReply | None = None) -> None:
        """Note that a page plays for so long, in place of what it played before."""
        now = time.monotonic()
        self._is_reply = reply is not None and seconds > 0
        if reply:
            self._played = (*self._played, (now, reply))[-MAX_REPLIES:]
        self._until = now + seconds + PLAYBACK_DELAY

    def busy_until(self) -> float:
        """When the last of it has left a loudspeaker, on the monotonic clock, s."""
        return max(self._until, self.robot.busy_until() if self.robot else 0.0)

    def replies(self) -> str | None:
        """What the page, or the robot, says, if that is a reply and all that sounds; else None."""
        now = time.monotonic()
        if self.robot and self.robot.busy_until() > now:
            return self.robot.replies() if self._until <= now else None
        return self._played[-1][1].text if self._is_reply else None

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        """What was played last: replies of the page if all that sounds is one, else the robot's."""
        now = time.monotonic()
        if self.robot and (not self._is_reply or self.robot.busy_until() > now):
            return self.robot.recent(seconds)
        sound = np.zeros(round(seconds * SAMPLE_RATE), np.float32)
        for begun, reply in self._played:
            place = len(sound) - round((now - begun) * SAMPLE_RATE)
            part = reply.sound[max(0, -place) :][: max(0, len(sound) - max(0, place))]
            sound[max(0, place) :][: len(part)] += part
        return sound, now
