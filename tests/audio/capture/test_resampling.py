"""One stream of any rate becomes 16 kHz, whatever its blocks; 16 kHz stays as it is."""

from __future__ import annotations

import numpy as np
import pytest

from voz.audio import SAMPLE_RATE
from voz.audio.capture.resampling import Resampler
from voz.audio.capture.sound_files import to_int16


def test_what_is_16_khz_stays_as_it_is() -> None:
    noise = np.random.default_rng(0).uniform(-1, 1, 999).astype(np.float32)
    resampler = Resampler(SAMPLE_RATE)
    assert np.array_equal(resampler.feed(noise), to_int16(noise))
    assert len(resampler.finish()) == 0


@pytest.mark.parametrize("rate", [8000, 44_100, 48_000])
def test_nothing_is_lost_between_blocks(rate: int) -> None:
    tone = np.sin(2 * np.pi * 300 * np.arange(rate) / rate).astype(np.float32) / 2
    resampler = Resampler(rate)
    parts = [resampler.feed(tone[at : at + 777]) for at in range(0, rate, 777)]
    found = np.concatenate([*parts, resampler.finish()])
    assert abs(len(found) - SAMPLE_RATE) <= 1
    expected = 16384 * np.sin(2 * np.pi * 300 * np.arange(len(found)) / SAMPLE_RATE)
    assert np.abs(found - expected)[500:-500].max() < 50
