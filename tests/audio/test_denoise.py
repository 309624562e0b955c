"""Noise is taken away where there is much of it, and speech is left alone."""

from __future__ import annotations

import numpy as np
import pytest
from recordings import Recording

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.denoise import denoise, denoise_if_noisy, frame_energies, is_noisy
from voz.audio.segmenter import segments


def hiss(length: int, loudness: float = 600) -> Samples:
    return np.random.default_rng(0).normal(0, loudness, length).astype(np.int16)


@pytest.fixture(scope="module")
def spoken(recordings: list[Recording]) -> list[Samples]:
    clips = [r for r in recordings if r.kind == "command" and r.voice == "festival_slt"]
    return [segment.samples for clip in clips for segment in segments([clip.samples()])]


def test_energies_are_those_of_each_10_ms() -> None:
    samples = np.concatenate([np.full(160, 100), np.zeros(160), np.full(80, 9)]).astype(np.int16)
    assert frame_energies(samples) == pytest.approx([40, 0], abs=0.01)
    assert len(frame_energies(np.zeros(0, np.int16))) == 0


def test_speech_in_a_quiet_room_is_left_as_it_is(spoken: list[Samples]) -> None:
    for samples in spoken:
        assert not is_noisy(samples)
        assert denoise_if_noisy(samples) is samples


def test_noise_gets_less_and_speech_stays(spoken: list[Samples]) -> None:
    for samples in spoken:
        noise = hiss(len(samples))
        noisy = np.clip(samples.astype(int) + noise, -32768, 32767).astype(np.int16)
        assert is_noisy(noisy)
        clean = denoise_if_noisy(noisy)
        assert (clean.dtype, len(clean)) == (np.int16, len(noisy))

        def error(heard: Samples, said: Samples = samples) -> float:
            return float(np.mean((heard.astype(float) - said) ** 2))

        assert error(clean) < 0.65 * error(noisy)


def test_noise_alone_is_turned_down() -> None:
    noise = hiss(SAMPLE_RATE)
    assert np.std(denoise(noise)) < 0.6 * np.std(noise)


@pytest.mark.parametrize("length", [0, 1, 159, 511, 513, 16001])
def test_any_length_stays_as_long(length: int) -> None:
    assert len(denoise(hiss(length))) == length
    assert len(denoise_if_noisy(hiss(length))) == length
