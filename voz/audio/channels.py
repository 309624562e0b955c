"""One channel of several: their mean, with those turned over that would cancel the others."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt

Mono = npt.NDArray[np.float32]

OUT_OF_PHASE = "its channels are out of phase and would cancel each other; voz turns one over"
"""A warning, to be said once; what has the channels is its subject."""

FRAME_SECONDS = 0.01
"""Of so much sound it is decided together; a block of a microphone is three frames."""

MEMORY_SECONDS = 0.25
"""What was heard before counts for e times less after this time."""

MIN_POWER_LEFT = 0.5
"""Channels cancel each other if less of their power is left; all is left of what has nothing in
common, and more of what has."""

MIN_POWER = 1e-8
"""Of differences between samples, -80 dBFS in one frame: in less there is no speech."""


class ChannelMixer:
    """Makes one channel of a stream; the size of its blocks makes no difference.

    A microphone with a plug wired the wrong way round gives each sound twice, once upside down: the
    mean is silence. Signs change with a fade over a frame, so that nothing clicks.
    """

    def __init__(self, rate: float) -> None:
        """Start a stream of a rate, Hz."""
        self.out_of_phase = False  # whether channels ever were
        self._size = max(1, round(FRAME_SECONDS * rate))
        self._decay = float(np.exp(-FRAME_SECONDS / MEMORY_SECONDS))
        self._rest = np.empty((0, 1), np.float32)
        self._begin(self._rest)

    def feed(self, sound: npt.NDArray[np.float32]) -> Mono:
        """Mix the next samples x channels, -1 to 1; keeps less than a frame of several for later.

        The channels may become more or fewer.
        """
        if sound.shape[1] == self._rest.shape[1]:
            return self._feed(sound)
        before = self.finish()
        self._begin(sound[:0])
        return np.concatenate([before, self._feed(sound)])

    def finish(self) -> Mono:
        """End the stream; returns its last samples."""
        rest, self._rest = self._rest, self._rest[:0]
        return (rest * self._signs).mean(axis=1) if len(rest) else np.empty(0, np.float32)

    def _begin(self, nothing: npt.NDArray[np.float32]) -> None:
        channels = nothing.shape[1]
        self._rest = nothing
        self._last = nothing  # the last sample of the frame before
        self._signs: Mono = np.ones(channels, np.float32)
        self._shared = np.zeros((channels, channels))  # power that each two have in common

    def _feed(self, sound: npt.NDArray[np.float32]) -> Mono:
        if sound.shape[1] == 1:
            return sound[:, 0]
        whole = np.concatenate([self._rest, sound])
        count = len(whole) // self._size
        self._rest = whole[count * self._size :]
        if not count:
            return np.empty(0, np.float32)
        frames = whole[: count * self._size]
        begins, signs = self._decide(self._measure(frames, count))
        mixed = [
            self._mix(frames[a * self._size : b * self._size], before, after)
            for (a, b), (before, after) in zip(
                pairwise([*begins, count]), pairwise(signs), strict=True
            )
            if a < b
        ]
        return np.concatenate(mixed)

    def _measure(self, frames: npt.NDArray[np.float32], count: int) -> npt.NDArray[np.float64]:
        """Return what each two channels have in common, of shape (frames, channels, channels).

        Of differences between samples: hum is the same in all channels, whatever the speech is.
        """
        last = self._last if len(self._last) else frames[:1]
        self._last = frames[-1:]
        changes = np.diff(frames, axis=0, prepend=last).reshape(count, self._size, -1)
        found: npt.NDArray[np.float64] = np.matmul(changes.swapaxes(1, 2), changes, dtype=float)
        return found / self._size

    def _decide(
        self, shared: npt.NDArray[np.float64]
    ) -> tuple[list[int], list[npt.NDArray[np.float32]]]:
        """Return the frames in which stretches begin, and the signs before and in each of them.

        Signs stay until what they make cancels itself.
        """
        begins, signs = [0], [self._signs, self._signs]
        for frame, new in enumerate(shared):
            self._shared = self._decay * self._shared + new
            left, power = _power_of(self._shared, signs[-1]), np.trace(self._shared)
            if left >= MIN_POWER_LEFT * power or power < MIN_POWER:
                continue
            better = _signs_of(self._shared, signs[-1])
            if _power_of(self._shared, better) > left:
                begins.append(frame)
                signs.append(better)
                self.out_of_phase = True
        self._signs = signs[-1]
        return begins, signs

    def _mix(
        self,
        sound: npt.NDArray[np.float32],
        before: npt.NDArray[np.float32],
        signs: npt.NDArray[np.float32],
    ) -> Mono:
        if (signs > 0).all() and before is signs:
            mean: Mono = sound.mean(axis=1)
            return mean
        mixed: Mono = (sound * signs).mean(axis=1)
        if before is not signs:
            fade = np.linspace(1, 0, self._size, endpoint=False, dtype=np.float32)
            old = (sound[: self._size] * before).mean(axis=1)
            mixed[: self._size] += fade * (old - mixed[: self._size])
        return mixed


def _power_of(shared: npt.NDArray[np.float64], signs: npt.NDArray[np.float32]) -> float:
    """Return the power of the sum of channels with these signs."""
    return float(signs @ shared @ signs)


def _signs_of(
    shared: npt.NDArray[np.float64], before: npt.NDArray[np.float32]
) -> npt.NDArray[np.float32]:
    """Return the signs by which channels add up; of two possible ones those nearer to before."""
    _, vectors = np.linalg.eigh(shared)
    signs = np.where(vectors[:, -1] < 0, -1, 1).astype(np.float32)
    agreement = float(signs @ before) or float(signs[0])
    return signs if agreement > 0 else -signs
