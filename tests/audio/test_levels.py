"""Levels of frames: each as it would be alone, in whatever company it comes."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recordings import FIXTURES

from voz.audio.levels import (
    BACKGROUND_FRAMES,
    BACKGROUND_QUANTILE,
    BAND_EDGES,
    FRAME,
    MIN_SILENCE_DEPTH,
    MIN_SILENT_SHARE,
    QUIET_ROOM_LEVEL,
    SILENCE_FRAMES,
    SILENCE_QUANTILE,
    SMOOTHED_SPECTRA,
    SPECTRUM_HOP,
    SPECTRUM_WINDOW,
    Background,
    BandLevels,
    LevelMeter,
    quantile,
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
        patch.setattr("voz.audio.levels.BATCH_FRAMES", at_once)
        for size in [*sizes, COUNT]:
            found += pieces.measure(rest[: size * FRAME])
            rest = rest[size * FRAME :]
    assert found == whole.measure(SOUND)


levels = st.tuples(*[st.sampled_from([0.0, 12.5, 20.0, 31.0, 31.5, 60.0])] * 2)
stretches = st.lists(
    st.tuples(levels, st.booleans(), st.integers(1, 200), st.booleans()), max_size=8
)


def below(values: list[float], share: float) -> float:
    return sorted(values)[int(share * (len(values) - 1))]


def background_by_definition(heard: list[tuple[BandLevels, bool]]) -> list[float]:
    found = []
    for band in (0, 1):
        background = below(
            [level[band] for level, _ in heard[-BACKGROUND_FRAMES:]], BACKGROUND_QUANTILE
        )
        recent = heard[-SILENCE_FRAMES:]
        silent = [level[band] for level, voice in recent if not voice]
        if len(silent) >= MIN_SILENT_SHARE * len(recent):
            silence = below(silent, SILENCE_QUANTILE)
            background = silence if background - silence > MIN_SILENCE_DEPTH else background
        found.append(background)
    return found


@settings(max_examples=30)
@given(stretches)
def test_it_is_what_the_definition_says(found: list[tuple[BandLevels, bool, int, bool]]) -> None:
    background = Background()
    heard: list[tuple[BandLevels, bool]] = [
        ((QUIET_ROOM_LEVEL, QUIET_ROOM_LEVEL), False)
    ] * BACKGROUND_FRAMES
    for level, voice, count, settled in found:
        if settled:
            background.settle(level)
            heard = [(level, True)] * SILENCE_FRAMES
        for _ in range(count):
            heard.append((level, voice))
            told = background.follow(level, voice)
        assert list(told) == background_by_definition(heard)
    assert background.voices == np.mean([voice for _, voice in heard[-SILENCE_FRAMES:]])


def test_what_is_long_ago_is_forgotten() -> None:
    old, new = Background(), Background()
    for _ in range(5000):
        old.follow((50.0, 40.0), True)
    for number in range(SILENCE_FRAMES):
        level = (20.0 + number % 7, 10.0)
        told = old.follow(level, False), new.follow(level, False)
    assert told[0] == told[1]
    assert (old.level, old.voices) == (new.level, new.voices)
    assert old.loudest(SILENCE_FRAMES, 0) == new.loudest(SILENCE_FRAMES, 0) == 26.0


@given(
    values=st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=40),
    columns=st.integers(1, 3),
    share=st.floats(0, 1),
)
def test_they_are_those_of_numpy(values: list[float], columns: int, share: float) -> None:
    table = np.array([values] * columns).T
    found, expected = quantile(table, share), np.quantile(table, share, axis=0)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-6)
    assert quantile(values, share) == pytest.approx(found[0])


def test_to_understand_a_recording_loads_neither_masked_arrays_nor_openssl() -> None:
    recording = FIXTURES / "commands" / "festival_slt__go_forward.flac"
    program = "import sys, voz; print(*voz.load().decode(sys.argv[1])); print(*sys.modules)"
    told = subprocess.check_output([sys.executable, "-c", program, recording], timeout=120)
    assert b"go forward" in told
    assert not {b"numpy.ma", b"_hashlib"} & {*told.split()}
