"""What a room sounds like between what is said in it: followed all the time, in level; pure."""

from __future__ import annotations

from array import array
from bisect import bisect_left, insort
from collections.abc import Iterable
from typing import NamedTuple

from voz.audio import SAMPLE_RATE
from voz.audio.endpointing.frame_levels import FRAME, BandLevels

BACKGROUND_FRAMES = 4 * SAMPLE_RATE // FRAME
"""Frames that the background is taken from."""

BACKGROUND_QUANTILE = 0.8
"""Of the time it is no louder than the background.

By the half of the time a person who talks in the background stands out of it with each word, and
the clatter of a kitchen too.
"""

SILENCE_FRAMES = 8 * SAMPLE_RATE // FRAME
MIN_SILENT_SHARE = 0.36
"""Of so many frames without a voice the silence is taken, in a room that is quiet.

Where one command follows the other the room is silent for more of the time. Where somebody talks
on and on it is not, and what stands out of the talk is wanted.
"""

SILENCE_QUANTILE = 0.95
"""Of the silence; the rest is breath, and the ends of words."""

QUIET_ROOM_LEVEL = 20.0
"""The level of a quiet room, dB over one unit of the 16 bits."""

MIN_SILENCE_DEPTH = 20.0
"""By so much silence is below the background, dB, where that was taken from what was said."""

MAX_KEPT_FRAMES = 4096
"""Frames that are held before all but the last ones go."""

STEADY_FRAMES = 14
"""Frames, 0.4 s, in which a sound that goes on is known by its level."""

RISE_FRAMES = 6
"""Frames in which something comes up out of what was steady."""


class SteadyNoise(NamedTuple):
    """A sound that goes on: its usual levels in both bands, and the highest, dB."""

    usual: BandLevels
    highest: BandLevels


class _SortedLevels:
    """The levels of some frames in both bands, each in order: a new one is put into its place."""

    def __init__(self, levels: Iterable[BandLevels]) -> None:
        self._bands = [sorted(band) for band in zip(*levels, strict=True)] or [[], []]

    def __len__(self) -> int:
        return len(self._bands[0])

    def add(self, level: BandLevels) -> None:
        for band, value in zip(self._bands, level, strict=True):
            insort(band, value)

    def drop(self, level: BandLevels) -> None:
        for band, value in zip(self._bands, level, strict=True):
            del band[bisect_left(band, value)]

    def quantile(self, share: float) -> BandLevels:
        """The level in each band that so much of them is below."""
        low, high = self._bands
        place = int(share * (len(low) - 1))
        return low[place], high[place]


class Background:
    """Follows the level of a room, by frames of 30 ms."""

    def __init__(self) -> None:
        """Start with nothing heard, as if it had been silent."""
        self._fill((QUIET_ROOM_LEVEL, QUIET_ROOM_LEVEL), False, BACKGROUND_FRAMES)
        self._level_now = QUIET_ROOM_LEVEL

    def follow(self, level: BandLevels, voice: bool) -> BandLevels:
        """Take the next frame of the stream.

        Args:
            level: how loud it is.
            voice: whether there may be a voice in it.

        Returns:
            The levels of the background with it.
        """
        self._add(level, voice)
        low, high = self._recent.quantile(BACKGROUND_QUANTILE)
        if len(self._silent) >= MIN_SILENT_SHARE * min(len(self._levels), SILENCE_FRAMES):
            least_low, least_high = self._silent.quantile(SILENCE_QUANTILE)
            low = least_low if low - least_low > MIN_SILENCE_DEPTH else low
            high = least_high if high - least_high > MIN_SILENCE_DEPTH else high
        self._level_now = low
        return low, high

    @property
    def level(self) -> float:
        """Of the room between 250 and 3,400 Hz now, dB over one unit of the 16 bits."""
        return self._level_now

    @property
    def voices(self) -> float:
        """The share of the last 8 s that a voice may be in."""
        voices = self._voices[-SILENCE_FRAMES:]
        return sum(voices) / len(voices)

    def state(self) -> bytes:
        """All that what follows hangs on."""
        levels = array("d", (band for lv in self._levels[-SILENCE_FRAMES:] for band in lv))
        return levels.tobytes() + bytes(self._voices[-SILENCE_FRAMES:])

    def loudest(self, frames: int, but: int) -> float:
        """Find the highest level of the last frames but some, dB; 0 if there are none."""
        frames = min(frames, SILENCE_FRAMES)
        end = len(self._levels)
        found = self._levels[max(0, end - frames) : max(0, end - but)]
        return max((low for low, _ in found), default=0.0)

    def settle(self, level: BandLevels) -> None:
        """Take the levels of a noise that has just begun for the background."""
        self._fill(level, True, SILENCE_FRAMES)

    def risen_above(self, by: float, steady_within: float) -> SteadyNoise | None:
        """Tell how loud a sound is that goes on, if something rose out of it just now.

        Args:
            by: how far the last two frames are above it, dB.
            steady_within: by how much it may change meanwhile, dB.

        Returns:
            Its usual levels before that, and the highest; None if it was not steady, or nothing
            rose.
        """
        last = self._levels[-STEADY_FRAMES - RISE_FRAMES :]
        before, now = last[:STEADY_FRAMES], last[-2:]
        lows = [low for low, _ in before]
        if max(lows) - min(lows) >= steady_within:
            return None
        steady = _SortedLevels(before).quantile(BACKGROUND_QUANTILE)
        if min(low for low, _ in now) <= steady[0] + by:
            return None
        return SteadyNoise(steady, (max(lows), max(high for _, high in before)))

    def _add(self, level: BandLevels, voice: bool) -> None:
        """Add a frame; of those that are looked at the oldest goes."""
        self._recent.drop(self._levels[-BACKGROUND_FRAMES])
        self._recent.add(level)
        if len(self._levels) >= SILENCE_FRAMES and not self._voices[-SILENCE_FRAMES]:
            self._silent.drop(self._levels[-SILENCE_FRAMES])
        if not voice:
            self._silent.add(level)
        self._levels.append(level)
        self._voices.append(voice)
        if len(self._levels) > MAX_KEPT_FRAMES:
            del self._levels[:-SILENCE_FRAMES], self._voices[:-SILENCE_FRAMES]

    def _fill(self, level: BandLevels, voice: bool, count: int) -> None:
        """Take so many frames before now for such ones."""
        self._levels, self._voices = [level] * count, [voice] * count
        self._recent = _SortedLevels(self._levels[-BACKGROUND_FRAMES:])
        self._silent = _SortedLevels([] if voice else self._levels)
