"""The background of a room is what its definition says, whatever is heard."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from voz.audio.endpointing.background import (
    BACKGROUND_FRAMES,
    BACKGROUND_QUANTILE,
    MIN_SILENCE_DEPTH,
    MIN_SILENT_SHARE,
    QUIET_ROOM_LEVEL,
    SILENCE_FRAMES,
    SILENCE_QUANTILE,
    Background,
)
from voz.audio.endpointing.frame_levels import BandLevels

levels = st.tuples(*[st.sampled_from([0.0, 12.5, 20.0, 31.0, 31.5, 60.0])] * 2)
stretches = st.lists(
    st.tuples(levels, st.booleans(), st.integers(1, 200), st.booleans()), max_size=8
)


def below(values: list[float], share: float) -> float:
    return sorted(values)[int(share * (len(values) - 1))]


def by_definition(heard: list[tuple[BandLevels, bool]]) -> list[float]:
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
        assert list(told) == by_definition(heard)
    assert background.voices == np.mean([voice for _, voice in heard[-SILENCE_FRAMES:]])


def test_what_is_long_ago_is_forgotten() -> None:
    old, new = Background(), Background()
    for _ in range(5000):
        old.follow((50.0, 40.0), True)
    for number in range(SILENCE_FRAMES):
        for each in (old, new):
            each.follow((20.0 + number % 7, 10.0), False)
    assert old.state() == new.state()
