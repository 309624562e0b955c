"""Several channels become one, and channels out of phase do not become silence."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from recordings import Recording

from voz.audio import SAMPLE_RATE
from voz.audio.channels import ChannelMixer


@pytest.fixture
def speech(session: Recording) -> np.ndarray:
    return session.samples()[: 20 * SAMPLE_RATE] / np.float32(32768)


def mixed(channels: np.ndarray, size: int | None = None) -> tuple[np.ndarray, bool]:
    """The one channel, from blocks of a size, and whether it was told that they cancel."""
    mixer, size = ChannelMixer(SAMPLE_RATE), size or len(channels)
    blocks = [channels[at : at + size] for at in range(0, len(channels), size)]
    found = [mixer.feed(block.astype(np.float32)) for block in blocks]
    return np.concatenate([*found, mixer.finish()]), mixer.out_of_phase


def noise(like: np.ndarray, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, 0.003, len(like))


Make = Callable[[np.ndarray], np.ndarray]


@pytest.mark.parametrize(
    "make",
    [
        lambda s: np.stack([s, -s], axis=1),
        lambda s: np.stack([-0.4 * s, s], axis=1),
        lambda s: np.stack([s, -s, s], axis=1),
        lambda s: np.stack([s, -s, 0 * s, 0 * s], axis=1),
        lambda s: np.stack([s + noise(s, 1), noise(s, 2) - s], axis=1),
    ],
)
def test_channels_out_of_phase_are_heard(make: Make, speech: np.ndarray) -> None:
    mono, told = mixed(make(speech))
    assert told
    assert len(mono) == len(speech)
    assert abs(np.corrcoef(mono, speech)[0, 1]) > 0.95
    assert np.sqrt((mono**2).mean()) > 0.4 * np.sqrt((speech**2).mean())


@pytest.mark.parametrize(
    "make",
    [
        lambda s: np.stack([s, s], axis=1),
        lambda s: np.stack([s, 0 * s], axis=1),
        lambda s: np.stack([s, -0.1 * s], axis=1),
        lambda s: np.stack([s, np.roll(s, 5)], axis=1),
        lambda s: np.stack([noise(s, n) for n in range(6)], axis=1),
        lambda s: np.zeros((len(s), 2)),
        lambda s: s[:, None],
    ],
)
def test_of_all_others_it_is_the_mean(make: Make, speech: np.ndarray) -> None:
    channels = make(speech).astype(np.float32)
    mono, told = mixed(channels)
    assert not told
    assert np.array_equal(mono, channels.mean(axis=1))


@pytest.mark.parametrize("size", [1, 100, 480, 1000])
def test_the_size_of_the_blocks_makes_no_difference(size: int, speech: np.ndarray) -> None:
    channels = np.stack([speech, -speech], axis=1)[: 2 * SAMPLE_RATE]
    channels[: SAMPLE_RATE // 2, 1] *= -1
    assert np.array_equal(mixed(channels, size)[0], mixed(channels)[0])


def test_where_channels_turn_over_nothing_clicks() -> None:
    tone = 0.5 * np.sin(2 * np.pi * 200 * np.arange(4 * SAMPLE_RATE) / SAMPLE_RATE)
    other = tone.copy()
    other[SAMPLE_RATE : 2 * SAMPLE_RATE] *= -1
    mono, told = mixed(np.stack([tone, other], axis=1))
    assert told
    step = np.abs(np.diff(tone)).max()
    at_the_turns = [slice(n * SAMPLE_RATE - 2, n * SAMPLE_RATE + 2) for n in (1, 2)]
    steps = np.abs(np.diff(mono))
    for turn in at_the_turns:
        steps[turn] = 0  # where the sound itself turns over
    assert steps.max() < 1.5 * step
    for second in (0.9, 1.9, 2.9, 3.9):
        there = mono[int((second - 0.1) * SAMPLE_RATE) : int(second * SAMPLE_RATE)]
        assert np.abs(there).max() == pytest.approx(0.5, rel=0.02)


def test_the_number_of_channels_may_change(speech: np.ndarray) -> None:
    mixer = ChannelMixer(SAMPLE_RATE)
    stereo = np.stack([speech, speech], axis=1)[:1001]
    found = [mixer.feed(stereo), mixer.feed(speech[:1001, None]), mixer.feed(stereo)]
    whole = np.concatenate([*found, mixer.finish()])
    assert np.array_equal(whole, np.tile(speech[:1001], 3))
