from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.apps.evaluation import noise
from voz.audio import SAMPLE_RATE, Samples
from voz.errors import VozError


def some_noise(seconds: float, level: float, seed: int = 0) -> Samples:
    rng = np.random.default_rng(seed)
    return np.rint(level * rng.standard_normal(round(seconds * SAMPLE_RATE))).astype(np.int16)


def test_pauses_do_not_count_as_speech() -> None:
    speech = some_noise(1, 1000)
    power = noise.speech_power(speech)
    assert power == pytest.approx(1000**2, rel=0.03)
    with_pauses = np.concatenate([some_noise(1, 5), speech, np.zeros(SAMPLE_RATE, np.int16)])
    assert noise.speech_power(with_pauses) == pytest.approx(power)
    assert noise.speech_power(np.zeros(5000, np.int16)) == 0
    assert noise.speech_power(np.array([3], np.int16)) == 9


@given(
    ratio=st.floats(-5, 30),
    speech_level=st.floats(300, 1500),
    noise_level=st.floats(100, 5000),
    pause=st.floats(0, 1),
)
def test_the_ratio_of_a_mix_is_what_was_asked_for(
    ratio: float, speech_level: float, noise_level: float, pause: float
) -> None:
    silence = np.zeros(int(pause * SAMPLE_RATE), np.int16)
    speech = np.concatenate([silence, some_noise(0.5, speech_level), silence])
    background = some_noise(len(speech) / SAMPLE_RATE, noise_level, seed=1)
    added = noise.mix(speech, background, ratio).astype(float) - speech
    measured = 10 * np.log10(noise.speech_power(speech) / np.mean(added**2))
    assert measured == pytest.approx(ratio, abs=0.1)


def test_noise_goes_on_before_and_after_what_is_said() -> None:
    background, speech = some_noise(20, 1000, seed=1), some_noise(1, 3000)
    heard = noise.embed_in_noise(background, speech, 10, np.random.default_rng(0)).astype(float)
    before, after = round(noise.NOISE_BEFORE * SAMPLE_RATE), round(noise.NOISE_AFTER * SAMPLE_RATE)
    assert len(heard) == before + len(speech) + after
    levels = [np.sqrt(np.mean(part**2)) for part in (heard[:before], heard[-after:])]
    assert levels == pytest.approx([3000 / 10**0.5] * 2, rel=0.03)
    said = heard[before:-after] - speech
    assert np.sqrt(np.mean(said**2)) == pytest.approx(levels[0], rel=0.03)


def test_the_ratio_is_that_to_the_mean_of_noise_that_comes_and_goes() -> None:
    hum = some_noise(60, 1000, seed=1)
    comes_and_goes = np.concatenate([hum, np.zeros_like(hum)])
    speech = some_noise(1, 3000)
    powers = [
        np.mean(
            (noise.embed_in_noise(comes_and_goes, speech, 0, rng).astype(float)[:SAMPLE_RATE]) ** 2
        )
        for rng in map(np.random.default_rng, range(20))
    ]
    assert min(powers) == 0  # in a pause
    assert max(powers) == pytest.approx(2 * 3000**2, rel=0.05)


def test_what_would_overdrive_is_turned_down_together() -> None:
    speech, background = some_noise(1, 8000), some_noise(1, 8000, seed=1)
    sum_ = noise.mix(speech, background, 0).astype(float)
    assert np.abs(sum_).max() == 32767
    gains, *_ = np.linalg.lstsq(np.stack([speech, background], axis=1).astype(float), sum_)
    assert gains[0] == pytest.approx(gains[1], rel=0.05)


@given(st.integers(1, 3000), st.integers(1, 3000))
def test_a_stretch_is_as_long_as_asked_and_out_of_the_noise(there: int, wanted: int) -> None:
    ramp = np.arange(there, dtype=np.int16)
    cut = noise.random_stretch(ramp, wanted, np.random.default_rng(0))
    assert len(cut) == wanted
    assert all(np.diff(cut) % there == 1 % there)


def test_a_room_keeps_the_direct_path_and_falls_silent() -> None:
    response = noise.room_response(np.random.default_rng(0))
    assert response[0] == 1
    assert np.sum(response[1:] ** 2) == pytest.approx(10**-0.3)
    decay = np.array([np.mean(part**2) for part in np.array_split(response[1:], 4)])
    assert 10 * np.log10(decay[:-1] / decay[1:]) == pytest.approx([15, 15, 15], abs=1)


def test_a_click_in_a_room_is_the_response_of_the_room() -> None:
    click = np.zeros(100, np.int16)
    click[0] = 10000
    response = noise.room_response(np.random.default_rng(0))
    heard = noise.reverberate(click, response)
    assert len(heard) == 100 + len(response) - 1
    assert heard[: len(response)] == pytest.approx(10000 * response, abs=0.51)


def test_the_same_clip_gets_the_same_randomness_and_others_get_other() -> None:
    first, again, other = (noise.generator_for(name).random() for name in ("a", "a", "b"))
    assert first == again != other


def test_noise_is_a_file_or_all_recordings_in_a_folder(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    for name in ("b.wav", "sub/a.FLAC", "notes.txt"):
        (tmp_path / name).touch()
    assert noise.noise_files(tmp_path) == [tmp_path / "b.wav", tmp_path / "sub" / "a.FLAC"]
    assert noise.noise_files(tmp_path / "b.wav") == [tmp_path / "b.wav"]
    for path in (tmp_path / "none", tmp_path / "empty"):
        with pytest.raises(VozError, match="holds no recording"):
            noise.noise_files(path)


def test_ratios_are_numbers_with_commas() -> None:
    assert noise.parse_ratios("20, 10,-5.5") == (20, 10, -5.5)
    for text in ("", "loud", "20;10", "20,", "nan", "200", "inf"):
        with pytest.raises(VozError, match="write for instance 20,10,5"):
            noise.parse_ratios(text)
