"""The arithmetic of playing several sounds at once."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from voz.audio.playback import (
    AUDIBLE_AMPLITUDE,
    FADE_SAMPLES,
    HISTORY_SAMPLES,
    PLAYBACK_RATE,
    PlaybackHistory,
    PlayingSound,
    Wave,
    mix,
    to_16_khz,
    trim_leading_silence,
)

QUIET = st.floats(-0.25, 0.25, width=32)
waves = arrays.arrays(np.float32, st.integers(1, 700), elements=QUIET)
loud_waves = arrays.arrays(np.float32, st.integers(1, 700), elements=st.floats(-4, 4, width=32))
frames = st.integers(1, 600)


def taken(source: PlayingSound, sizes: list[int]) -> Wave:
    return np.concatenate([source.take(size) for size in sizes])


def tone(seconds: float, frequency: float = 440.0) -> Wave:
    return (
        0.5
        * np.sin(2 * np.pi * frequency * np.arange(int(seconds * PLAYBACK_RATE)) / PLAYBACK_RATE)
    ).astype(np.float32)


@given(waves, st.lists(frames, min_size=1, max_size=6))
def test_what_repeats_follows_itself_without_a_gap(wave: Wave, sizes: list[int]) -> None:
    source = PlayingSound(wave, repeats=True)
    heard = taken(source, sizes)
    assert np.array_equal(heard, np.resize(wave, sum(sizes)))
    assert not source.over


@given(waves, st.floats(0, 1), frames)
def test_volume_is_a_factor(wave: Wave, volume: float, size: int) -> None:
    heard = PlayingSound(wave, volume).take(size)
    assert np.allclose(heard, PlayingSound(wave).take(size) * volume, atol=1e-7)


@pytest.mark.parametrize("before", [1, 100, 480, 481])
@pytest.mark.parametrize("size", [1, 100, 480])
def test_a_stopped_sound_fades_out_in_5_ms_with_no_step(before: int, size: int) -> None:
    source = PlayingSound(np.full(10_000, 0.5, np.float32), repeats=True)
    heard = [source.take(before)]
    source.stop()
    while not source.over:
        heard.append(source.take(size))
    samples = np.concatenate(heard)
    assert len(samples) - before <= FADE_SAMPLES + size
    assert np.abs(np.diff(samples)).max() < 0.5 * 2 / FADE_SAMPLES  # the fade's own slope
    assert np.all(samples[:before] == 0.5)
    assert abs(samples[before + FADE_SAMPLES - 1]) < 0.001


def test_a_sound_that_is_stopped_before_it_began_is_over() -> None:
    source = PlayingSound(tone(1))
    source.stop()
    assert source.over


def test_stopping_twice_does_not_begin_the_fade_anew() -> None:
    source = PlayingSound(tone(1))
    source.take(480)
    source.stop()
    source.take(FADE_SAMPLES // 2)
    source.stop()
    source.take(FADE_SAMPLES // 2)
    assert source.over


def test_how_long_a_sound_is_audible_is_known() -> None:
    wave = np.concatenate([tone(0.1), np.zeros(1000, np.float32)])
    source = PlayingSound(wave)
    assert len(tone(0.1)) - 5 < source.audible_left <= len(tone(0.1))
    source.take(100)
    assert source.audible_left <= len(tone(0.1)) - 100
    source.stop()
    assert source.audible_left == FADE_SAMPLES
    assert PlayingSound(wave, repeats=True).audible_left == math.inf
    assert PlayingSound(np.zeros(100, np.float32), repeats=True).audible_left == 0
    assert PlayingSound(wave, volume=AUDIBLE_AMPLITUDE).audible_left == 0


@given(st.lists(loud_waves, max_size=4), st.lists(frames, min_size=1, max_size=5))
def test_no_sum_is_beyond_full_scale(several: list[Wave], sizes: list[int]) -> None:
    sources = [PlayingSound(wave, repeats=True) for wave in several]
    gain = 1.0
    for size in sizes:
        block, gain = mix(sources, size, gain)
        assert block.shape == (size,)
        assert np.abs(block).max() <= 1.0
        assert 0 < gain <= 1


def test_two_loud_sounds_are_turned_down_and_keep_their_shape() -> None:
    sources = [PlayingSound(2 * tone(1)), PlayingSound(2 * tone(1))]
    gain = 1.0
    blocks = []
    for _ in range(50):
        block, gain = mix(sources, 480, gain)
        blocks.append(block)
    settled = np.concatenate(blocks[5:])
    assert np.corrcoef(settled, tone(1)[5 * 480 : 50 * 480])[0, 1] > 0.999
    assert 0.95 < np.abs(settled).max() <= 1


def test_after_a_loud_sound_the_gain_comes_back() -> None:
    loud, quiet = PlayingSound(np.full(480, 4, np.float32)), PlayingSound(tone(2))
    _, gain = mix([loud, quiet], 480)
    assert gain < 0.3
    for _ in range(100):
        _, gain = mix([quiet], 480, gain)
    assert gain == 1.0


@given(arrays.arrays(np.float32, st.integers(1, 2000), elements=QUIET))
def test_silence_before_a_sound_is_left_out_but_for_10_ms(wave: Wave) -> None:
    silence = np.zeros(3000, np.float32)
    rest = trim_leading_silence(np.concatenate([silence, wave]))
    if np.abs(wave).max() <= AUDIBLE_AMPLITUDE:
        assert len(rest) == len(wave) + 3000
    else:
        first = int(np.argmax(np.abs(wave) > AUDIBLE_AMPLITUDE))
        assert len(rest) == len(wave) - first + PLAYBACK_RATE // 100
        assert np.array_equal(rest[PLAYBACK_RATE // 100 :], wave[first:])


class SoundsComeAndGo(RuleBasedStateMachine):
    """Against a model: all that sounds, written into one long line of samples beforehand."""

    @initialize()
    def begin(self) -> None:
        self.line = np.zeros(200_000)
        self.now = 0
        self.sources: list[PlayingSound] = []
        self.ends: list[float] = []
        self.heard: list[Wave] = []

    @rule(wave=waves)
    def play(self, wave: Wave) -> None:
        if sum(not source.over for source in self.sources) < 4:  # never too loud
            self.sources.append(PlayingSound(wave))
            self.line[self.now : self.now + len(wave)] += wave
            self.ends.append(self.now + len(wave))

    @rule(size=frames)
    def hear(self, size: int) -> None:
        block, gain = mix(self.sources, size)
        assert gain == 1.0
        self.heard.append(block)
        self.now += size

    @invariant()
    def what_was_heard_is_the_line(self) -> None:
        if self.heard:
            assert np.allclose(np.concatenate(self.heard), self.line[: self.now], atol=1e-6)

    @invariant()
    def what_is_over_has_ended(self) -> None:
        for source, end in zip(self.sources, self.ends, strict=True):
            assert source.over is (end <= self.now)


TestSoundsComeAndGo = SoundsComeAndGo.TestCase


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
