"""Splits a stretch that is too long for one utterance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from voz.audio.quantile import quantile

STEADY_QUANTILE = 0.5
"""Quantile of the levels that is the steady noise: motors, or a radio."""


class Piece(NamedTuple):
    """Frames that stand out: the first, and the one after the last."""

    start: int
    end: int


def pieces(levels: Sequence[float], above: float, pause: int) -> tuple[float, list[Piece]]:
    """Find what stands out of a steady noise.

    Args:
        levels: of the frames, dB.
        above: how far a frame stands out, dB.
        pause: number of quiet frames between two pieces.

    Returns:
        The level of the noise, dB, and the pieces in order.
    """
    usual = float(quantile(levels, STEADY_QUANTILE))
    found: list[Piece] = []
    for frame, level in enumerate(levels):
        if level <= usual + above:
            continue
        if found and frame - found[-1].end < pause:
            found[-1] = Piece(found[-1].start, frame + 1)
        else:
            found.append(Piece(frame, frame + 1))
    return usual, found
