"""A command that stops is found amid sound that goes on or is played, and others are not."""

from __future__ import annotations

import numpy as np
import pytest
from recordings import Recording

from voz.api.recognizer import Recognizer
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.echo import Cleaned
from voz.events import Partial
from voz.process.call_lock import NonReentrantLock
from voz.recognition.engine import open_playback_spotter
from voz.recognition.language import Language
from voz.recognition.network.score import PhonemeScorer
from voz.recognition.spotting import PLAYBACK_WINDOW, KeywordSpotter, PlaybackSpotter
from voz.recognition.thresholds import COMMAND_LIMITS, MIN_SPOTTING_SCORE


def clips(recordings: list[Recording]) -> list[Recording]:
    close = ("festival_", "flite_", "kokoro")
    return [r for r in recordings if r.kind == "command" and r.voice.startswith(close)]


def test_it_is_found_with_sound_before_it_and_no_other_command_is_it(
    scorer: PhonemeScorer, loaded: Language, recordings: list[Recording]
) -> None:
    spotter = KeywordSpotter(scorer, ["stop"], loaded.commands.listed, NonReentrantLock())
    hiss = np.random.default_rng(0).normal(0, 60, SAMPLE_RATE).astype(np.int16)
    found = {True: 0, False: 0}
    others = [clip for clip in clips(recordings) if clip.text != "stop"][::3]
    stops = [clip for clip in clips(recordings) if clip.text == "stop"]
    for clip in [*stops, *others]:
        samples = np.concatenate([hiss, clip.samples()])
        ends = range(len(hiss), len(samples), SAMPLE_RATE // 8)
        found[clip.text == "stop"] += any(spotter.spot(samples[:end]) for end in ends)
    assert found[True] == len(stops) > 3
    rightly = sum(clip.text == "stop speech" for clip in others)
    assert found[False] <= 0.1 * (len(others) - rightly) + rightly


def test_the_best_of_several_commands_is_given(
    scorer: PhonemeScorer, loaded: Language, recordings: list[Recording]
) -> None:
    spotter = KeywordSpotter(
        scorer, ["stop", "turn left"], loaded.commands.listed, NonReentrantLock()
    )
    for text in ("stop", "turn left"):
        clip = next(r for r in recordings if (r.voice, r.text) == ("festival_slt", text))
        spotted = spotter.spot(clip.samples())
        assert spotted
        assert spotted.text == text
        assert spotted.score > MIN_SPOTTING_SCORE


def in_machines(samples: Samples) -> Samples:
    """Let a machine begin to sound a second before, that goes on long after."""
    rng = np.random.default_rng(0)
    seconds = np.arange(len(samples) + 5 * SAMPLE_RATE) / SAMPLE_RATE
    loud = 300 * (1 + 0.5 * np.sin(2 * np.pi * 3 * seconds)) * (seconds > 1)
    sound = loud * rng.normal(0, 1, len(seconds)) + rng.normal(0, 4, len(seconds))
    sound[2 * SAMPLE_RATE : 2 * SAMPLE_RATE + len(samples)] += samples
    return np.clip(np.rint(sound), -32768, 32767).astype(np.int16)


def test_among_machines_a_stop_is_told_before_it_pauses(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    told = []
    for clip in clips(recordings):
        if clip.text != "stop":
            continue
        samples = clip.samples()
        said = np.flatnonzero(np.abs(samples) > np.abs(samples).max() / 20)[-1]
        until = 2 + said / SAMPLE_RATE
        events = recognizer.events([in_machines(samples)], "")
        first = next(e for e in events if isinstance(e, Partial) or e.accepted)
        is_in_time = until - 0.5 < first.t < until + 0.2
        told += [isinstance(first, Partial) and first.text == "stop" and is_in_time]
        assert 0 <= first.confidence <= 1
    assert len(told) > 3
    assert sum(told) >= len(told) - 1


def test_the_size_of_the_blocks_does_not_matter(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    clip = next(r for r in recordings if (r.voice, r.text) == ("festival_slt", "stop"))
    samples = in_machines(clip.samples())
    whole = list(recognizer.events([samples], ""))
    for size in (333, 4801):
        cut = (samples[at : at + size] for at in range(0, len(samples), size))
        assert list(recognizer.events(cut, "")) == whole


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
        found.append(spotter.check(sound, end / SAMPLE_RATE))
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
