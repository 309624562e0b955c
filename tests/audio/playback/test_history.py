"""What was heard when."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.audio.playback.history import HISTORY_SAMPLES, PlaybackHistory, to_16_khz
from voz.audio.playback.playing_sound import PLAYBACK_RATE, Wave

BLOCK = 480


def noise(seconds: float, seed: int = 0) -> Wave:
    """Noise that 16 kHz can hold."""
    import soxr

    found = np.random.default_rng(seed).normal(0, 0.1, int(seconds * 16_000)).astype(np.float32)
    return np.asarray(soxr.resample(found, 16_000, PLAYBACK_RATE), np.float32)


def give(history: PlaybackHistory, wave: Wave, time: float) -> float:
    for start in range(0, len(wave), BLOCK):
        history.add(wave[start : start + BLOCK], time + start / PLAYBACK_RATE)
    return time + len(wave) / PLAYBACK_RATE


def heard(history: PlaybackHistory, seconds: float, now: float) -> tuple[Wave, float]:
    cut, end = history.last(seconds, now)
    return to_16_khz(cut), end


def test_before_anything_was_played_there_is_silence() -> None:
    samples, end = heard(PlaybackHistory(), 1.0, now=1000.0)
    assert samples.shape == (16_000,)
    assert not samples.any()
    assert end == pytest.approx(1000.0, abs=0.001)


def test_what_was_played_is_found_at_its_time() -> None:
    history, wave = PlaybackHistory(), noise(2)
    end_of_wave = give(history, wave, time=500.0)
    samples, end = heard(history, 1.0, now=end_of_wave - 0.02)
    expected = to_16_khz(np.pad(wave, 240))  # from 500.0 on
    first = round((end - 500.0) * 16_000) - len(samples) + 1
    assert np.allclose(samples, expected[first : first + 16_000], atol=0.002)
    assert end_of_wave - 0.006 < end < end_of_wave


def test_all_calls_give_the_same_samples() -> None:
    history, wave = PlaybackHistory(), noise(1)
    give(history, wave[: PLAYBACK_RATE // 2], time=10.0)
    one, end_of_one = heard(history, 0.2, now=10.48)
    give(history, wave[PLAYBACK_RATE // 2 :], time=10.5)
    both, end_of_both = heard(history, 0.9, now=10.98)
    later = round((end_of_both - end_of_one) * 16_000)
    assert np.allclose(one, both[-later - len(one) : -later], atol=0.002)


def test_silence_between_two_sounds_is_kept() -> None:
    history = PlaybackHistory()
    give(history, noise(0.5, 1), time=10.0)
    end_of_second = give(history, noise(0.5, 2), time=12.0)
    samples, _ = heard(history, 2.4, now=end_of_second)
    level = np.abs(samples.reshape(-1, 1600)).max(axis=1) > 0.01
    # The last 5 ms are held back, so the parts are 5 ms late.
    assert list(level) == 5 * [True] + 14 * [False] + 5 * [True]


def test_after_the_last_sound_there_is_silence_up_to_now() -> None:
    history = PlaybackHistory()
    end_of_wave = give(history, noise(1), time=10.0)
    samples, end = heard(history, 1.0, now=end_of_wave + 0.5)
    assert end == pytest.approx(end_of_wave + 0.5, abs=0.001)
    assert np.abs(samples[:7000]).max() > 0.1
    assert np.abs(samples[8100:]).max() < 1e-6


def test_hours_of_silence_leave_nothing() -> None:
    history = PlaybackHistory()
    give(history, noise(1), time=10.0)
    end = give(history, noise(0.1), time=20_000.0)
    samples, _ = heard(history, 5.9, now=end)
    assert np.abs(samples[: -1600 - 200]).max() < 1e-6
    assert np.abs(samples[-1500:]).max() > 0.1
    assert history.end == pytest.approx(20_000.1, abs=0.001)


def test_the_time_of_the_last_audible_sample() -> None:
    history = PlaybackHistory()
    give(history, np.concatenate([noise(0.5), np.zeros(PLAYBACK_RATE // 2, np.float32)]), time=10.0)
    assert history.audible_until == pytest.approx(10.5, abs=0.002)
    assert history.end == pytest.approx(11.0, abs=0.002)
    give(history, np.zeros(BLOCK, np.float32), time=30.0)
    assert history.audible_until == pytest.approx(10.5, abs=0.002)


@given(st.lists(st.floats(-0.005, 0.005), min_size=200, max_size=200))
def test_a_trembling_clock_is_smoothed(errors: list[float]) -> None:
    history = PlaybackHistory()
    for number, error in enumerate(errors):
        history.add(np.zeros(BLOCK, np.float32), 10 + number * BLOCK / PLAYBACK_RATE + error)
    assert history.end == pytest.approx(10 + len(errors) * BLOCK / PLAYBACK_RATE, abs=0.0051)


def test_a_delay_that_changes_is_followed_at_once() -> None:
    history = PlaybackHistory()
    history.add(noise(0.01), 10.0)
    history.add(noise(0.01), 10.13)
    assert history.end == pytest.approx(10.14)
    assert history.audible_until == pytest.approx(10.14, abs=0.001)


@given(st.floats(0.1, 5.9), st.floats(0, 20), st.integers(0, 900))
def test_so_much_is_given_as_was_asked_for(seconds: float, pause: float, blocks: int) -> None:
    history = PlaybackHistory()
    for number in range(blocks):
        history.add(np.full(BLOCK, 0.1, np.float32), 100 + number * BLOCK / PLAYBACK_RATE)
    now = 100 + blocks * BLOCK / PLAYBACK_RATE + pause
    cut, end = history.last(seconds, now)
    assert len(to_16_khz(cut)) == round(seconds * 16_000)
    assert now - 0.006 < end < now + 0.001
    assert np.isfinite(cut).all()


def test_as_much_is_kept_as_is_promised() -> None:
    history = PlaybackHistory()
    wave = noise(8)
    end_of_wave = give(history, wave, time=0.5)
    assert HISTORY_SAMPLES == 6 * PLAYBACK_RATE
    samples, end = heard(history, 5.9, now=end_of_wave - 0.02)
    first = round((end - 0.5) * 16_000) - len(samples) + 1
    expected = to_16_khz(np.pad(wave, 240))[first : first + len(samples)]
    assert np.allclose(samples, expected, atol=0.002)
