"""Levels of frames: each as it would be alone, in whatever company it comes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from voz.audio.endpointing import frame_levels
from voz.audio.endpointing.frame_levels import (
    BAND_EDGES,
    FRAME,
    SMOOTHED_SPECTRA,
    SPECTRUM_HOP,
    SPECTRUM_WINDOW,
    LevelMeter,
)

COUNT = 40
SOUND = np.random.default_rng(1).normal(0, 300, COUNT * FRAME).astype(np.int16)
SOUND[: 8 * FRAME] = 0


def by_definition(sound: npt.NDArray[np.int16]) -> list[tuple[float, ...]]:
    """One spectrum after the other, and the mean of the last ones at the end of each frame."""
    window = np.hanning(SPECTRUM_WINDOW + 1)[:-1]
    padded = np.concatenate([np.zeros(SPECTRUM_WINDOW - SPECTRUM_HOP), sound])
    energies, found = [], []
    for at in range(0, len(sound), SPECTRUM_HOP):
        power = np.abs(np.fft.rfft(padded[at : at + SPECTRUM_WINDOW] * window)) ** 2
        low, middle, high = BAND_EDGES
        energies.append([power[low:middle].sum(), power[middle:high].sum()])
        if len(energies) % 3 == 0:
            mean = np.mean(energies[-SMOOTHED_SPECTRA:], axis=0) / (
                SPECTRUM_WINDOW * np.sum(window**2)
            )
            found.append(tuple(10 * np.log10(mean + 1)))
    return found


def test_they_are_what_the_definition_says() -> None:
    assert np.array(LevelMeter().measure(SOUND)) == pytest.approx(np.array(by_definition(SOUND)))


@settings(max_examples=30)
@given(st.lists(st.integers(0, 9)), st.integers(1, COUNT))
def test_they_are_the_same_in_whatever_pieces(sizes: list[int], at_once: int) -> None:
    whole, pieces = LevelMeter(), LevelMeter()
    found = []
    rest = SOUND
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(frame_levels, "BATCH_FRAMES", at_once)
        for size in [*sizes, COUNT]:
            found += pieces.measure(rest[: size * FRAME])
            rest = rest[size * FRAME :]
    assert found == whole.measure(SOUND)
    assert pieces.state() == whole.state()
