"""Sound in arrays of any kind becomes the same samples; what is no sound is one clear error."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import Recording

from voz.audio import SAMPLE_RATE
from voz.audio.capture.arrays import ArrayConverter, to_samples
from voz.errors import AudioError


def test_what_is_right_already_stays_as_it_is(session: Recording) -> None:
    samples = session.samples()
    assert np.array_equal(to_samples(samples, SAMPLE_RATE), samples)
    assert np.array_equal(to_samples(samples / 32768, SAMPLE_RATE), samples)


def test_channels_are_averaged() -> None:
    stereo = np.array([[100, 300], [-100, 100]], np.int16)
    assert to_samples(stereo, SAMPLE_RATE).tolist() == [200, 0]
    assert to_samples(stereo[:, :1], SAMPLE_RATE).tolist() == [100, -100]


@pytest.mark.parametrize("rate", [8000, 22_050, 44_100, 48_000.0])
def test_every_rate_becomes_16_khz(rate: float) -> None:
    seconds = np.arange(int(rate)) / rate
    tone = 0.5 * np.sin(2 * np.pi * 440 * seconds)
    found = to_samples(tone.astype(np.float32), rate)
    assert abs(len(found) - SAMPLE_RATE) <= 1
    assert np.argmax(np.abs(np.fft.rfft(found))) == pytest.approx(440, abs=1)
    assert np.abs(found[1000:-1000]).max() == pytest.approx(16384, rel=0.01)


@given(st.lists(st.integers(0, 700), max_size=12))
def test_the_size_of_the_blocks_does_not_matter(sizes: list[int]) -> None:
    sound = np.random.default_rng(0).integers(-9000, 9000, (sum(sizes), 2)).astype(np.int16)
    converter, at, found = ArrayConverter(24_000), 0, []
    for size in sizes:
        found.append(converter.feed(sound[at : at + size]))
        at += size
    whole = np.concatenate([*found, converter.finish()])
    assert np.abs(whole.astype(int) - to_samples(sound, 24_000)).max(initial=0) <= 1


@pytest.mark.parametrize(
    ("array", "said"),
    [
        (np.zeros((2, 16000), np.int16), r"shape \(2, 16000\).*turn it round"),
        (np.zeros((2, 3, 4), np.int16), "samples x channels"),
        (np.zeros(9, np.int32), "samples are int32; give int16, or floats"),
        (np.array(["a"]), "give int16"),
        (np.array([0.0, np.nan]), "no numbers"),
        (np.array([0.0, 1200.0]), "one is 1200; divide by 32768"),
        (np.array(0.5), "samples x channels"),
    ],
)
def test_what_is_no_sound_is_one_clear_error(array: np.ndarray, said: str) -> None:
    with pytest.raises(AudioError, match=said):
        to_samples(array, SAMPLE_RATE)


@pytest.mark.parametrize("rate", [0, 300, -16000, 1e9, float("nan")])
def test_a_rate_without_speech_is_refused(rate: float) -> None:
    with pytest.raises(AudioError, match=r"sample rate of .* Hz is not usable"):
        to_samples(np.zeros(9, np.int16), rate)


@pytest.mark.parametrize("rate", ["16000", [16000]])
def test_what_is_no_rate_is_refused_as_clearly(rate: Any) -> None:
    with pytest.raises(AudioError, match="is not usable; give one from"):
        to_samples(np.zeros(9, np.int16), rate)


@pytest.mark.parametrize("rate", [SAMPLE_RATE, 44_100])
def test_a_stream_that_is_finished_says_so(rate: int) -> None:
    converter = ArrayConverter(rate)
    converter.feed(np.zeros(rate, np.int16))
    converter.finish()
    with pytest.raises(AudioError, match="is finished; begin another"):
        converter.feed(np.zeros(rate, np.int16))
    assert len(converter.finish()) == 0
