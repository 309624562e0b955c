"""What is known of what a page plays."""

from __future__ import annotations

import time

import numpy as np
import numpy.typing as npt

from voz.apps.web.page_sound import PLAYBACK_DELAY, PagePlayback, PageReply
from voz.audio import SAMPLE_RATE

REPLY = PageReply("I am listening", np.full(SAMPLE_RATE // 2, 0.5, np.float32))


class RobotLoudspeaker:
    """One that sounds for a second from now on."""

    def __init__(self) -> None:
        self._until = time.monotonic() + 1

    def busy_until(self) -> float:
        """The end of its sound."""
        return self._until

    def replies(self) -> str:
        """What it says."""
        return "good morning"

    def recent(self, seconds: float) -> tuple[npt.NDArray[np.float32], float]:
        """A constant sound."""
        return np.ones(round(seconds * SAMPLE_RATE), np.float32), time.monotonic()


def test_the_sound_of_a_reply_is_known_where_it_is_played() -> None:
    playback = PagePlayback()
    before = time.monotonic()
    playback.start(0.5, REPLY)
    assert playback.replies() == "I am listening"
    assert before + 0.5 + PLAYBACK_DELAY <= playback.busy_until()
    sound, end = playback.recent(2.0)
    while end < before + 0.6:
        sound, end = playback.recent(2.0)
    assert len(sound) == 2 * SAMPLE_RATE
    (places,) = np.nonzero(sound)
    assert len(places) == len(REPLY.sound)
    begun = end - (len(sound) - places[0]) / SAMPLE_RATE
    assert before - 0.001 <= begun <= end - 0.5
    assert not playback.recent(0.01)[0].any()


def test_of_a_recording_that_a_page_plays_nothing_is_known() -> None:
    playback = PagePlayback()
    playback.start(0.5, REPLY)
    playback.start(1.0)
    assert playback.replies() is None
    playback.start(0.5, REPLY)
    playback.start(0.0)
    assert playback.replies() is None


def test_while_the_robot_sounds_too_only_its_own_sound_is_known() -> None:
    playback = PagePlayback()
    playback.robot = RobotLoudspeaker()
    playback.start(0.5, REPLY)
    assert playback.replies() is None
    assert playback.recent(0.5)[0].all()


def test_of_the_robots_own_reply_the_words_are_known() -> None:
    playback = PagePlayback()
    playback.robot = RobotLoudspeaker()
    assert playback.replies() == "good morning"
    assert playback.recent(0.5)[0].all()
