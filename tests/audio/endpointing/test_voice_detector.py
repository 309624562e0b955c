"""Speech is told from other sound."""

from __future__ import annotations

import numpy as np
import pytest
from recordings import Recording

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.capture.sound_files import read_blocks
from voz.audio.endpointing.segmenter import segments
from voz.audio.endpointing.voice_detector import VoiceDetector


@pytest.fixture(scope="module")
def detector() -> VoiceDetector:
    return VoiceDetector()


def sounds() -> list[Samples]:
    chance = np.random.default_rng(0)
    time = np.arange(SAMPLE_RATE) / SAMPLE_RATE
    hum = 3000 * np.sin(2 * np.pi * 100 * time) + 1000 * np.sin(2 * np.pi * 300 * time)
    taps = 8000 * np.exp(-time % 0.2 * 60) * np.sin(2 * np.pi * 2500 * time)
    return [s.astype(np.int16) for s in (chance.normal(0, 2000, SAMPLE_RATE), hum, taps)]


def test_noise_hum_and_taps_are_no_speech(detector: VoiceDetector) -> None:
    assert max(detector.probability(sound) for sound in sounds()) < 0.5


def test_commands_are_speech(detector: VoiceDetector, recordings: list[Recording]) -> None:
    clips = [r for r in recordings if r.kind == "command"][::3]
    found = [
        detector.probability(segment.samples)
        for clip in clips
        for segment in segments(read_blocks(clip.path))
    ]
    assert np.mean(np.array(found) > 0.5) > 0.97
    assert np.mean(np.array(found) >= 0.65) > 0.9


def test_hardly_any_sound_is_no_speech(detector: VoiceDetector) -> None:
    assert detector.probability(np.zeros(511, np.int16)) == 0.0


def test_what_came_before_does_not_matter(
    detector: VoiceDetector, recordings: list[Recording]
) -> None:
    clip = recordings[0].samples()
    alone = VoiceDetector().probability(clip)
    detector.probability(np.full(SAMPLE_RATE, 20_000, np.int16))
    assert detector.probability(clip) == alone
