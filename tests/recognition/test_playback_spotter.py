"""What is said while the robot speaks, and what is left of its own words."""

from __future__ import annotations

import numpy as np
import pytest
from recordings import Recording

from voz.audio import SAMPLE_RATE
from voz.audio.echo import Cleaned
from voz.recognition.playback_spotter import (
    COMMAND_LIMITS,
    PLAYBACK_WINDOW,
    PlaybackSpotter,
)
from voz.recognition.recognizer import Recognizer, open_playback_spotter


@pytest.fixture
def spotter(recognizer: Recognizer) -> PlaybackSpotter:
    return open_playback_spotter(recognizer, "microphone")


@pytest.fixture
def stop(recordings: list[Recording]) -> np.ndarray:
    """A word with a second and a half of a quiet room before and after it."""
    clip = next(r for r in recordings if r.text == "stop" and r.voice == "flite_slt").samples()
    said = np.pad(clip, 3 * SAMPLE_RATE // 2)
    return said + np.random.default_rng(0).normal(0, 8, len(said))


def looks(spotter: PlaybackSpotter, left: np.ndarray, played: np.ndarray) -> list[str]:
    """What is found in looks that follow each other, of which each word is in several."""
    found = []
    for end in range(PLAYBACK_WINDOW, len(left), SAMPLE_RATE // 4):
        part = slice(end - PLAYBACK_WINDOW, end)
        sound = Cleaned(
            left[part].astype(np.int16),
            (played[part] / 32768).astype(np.float32),
            (played[part] - left[part]).astype(np.float32),
        )
        found.append(spotter.look(sound, end / SAMPLE_RATE))
    return [utterance.text for utterance in found if utterance]


def test_a_stop_that_several_looks_find_is_one(spotter: PlaybackSpotter, stop: np.ndarray) -> None:
    assert looks(spotter, stop, np.zeros(len(stop)))[:1] == ["stop"]


def test_what_is_left_of_the_robots_own_stop_is_none(
    spotter: PlaybackSpotter, stop: np.ndarray
) -> None:
    assert looks(spotter, 0.1 * stop, stop) == []


def test_a_command_is_said_if_it_stands_out_and_was_not_played(
    spotter: PlaybackSpotter, stop: np.ndarray
) -> None:
    samples, nothing = stop.astype(np.int16), np.zeros(len(stop), np.float32)
    said = Cleaned(samples, nothing, nothing)
    assert spotter.is_said("stop", said, 1.5, 3.0, COMMAND_LIMITS)
    assert not spotter.is_said("fold arm", said, 1.5, 3.0, COMMAND_LIMITS)
    echo = Cleaned(samples, (stop / 32768).astype(np.float32), nothing)
    assert not spotter.is_said("stop", echo, 1.5, 3.0, COMMAND_LIMITS)
    assert spotter.may_be_echo("stop", (stop / 32768).astype(np.float32))
    assert not spotter.may_be_echo("fold arm", (stop / 32768).astype(np.float32))
