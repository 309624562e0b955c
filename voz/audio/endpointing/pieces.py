"""What stands out within a stretch that goes on for too long to be one utterance; pure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

STEADY_QUANTILE = 0.5
"""Of the stretch it is no louder than what goes on in it: motors, or a radio that was turned on."""


class Piece(NamedTuple):
    """Frames that stand out: the first, and the one after the last."""

    start: int
    end: int


def pieces(levels: Sequence[float], above: float, pause: int) -> tuple[float, list[Piece]]:
    """Find what stands out of what goes on.

    Args:
        levels: of the frames of the stretch, dB.
        above: how far it stands out, dB.
        pause: so many frames that do not stand out divide two pieces.

    Returns:
        The level that they stand out of, dB, and the pieces in their order.
    """
    usual = float(np.quantile(levels, STEADY_QUANTILE))
    found: list[Piece] = []
    for frame, level in enumerate(levels):
        if level <= usual + above:
            continue
        if found and frame - found[-1].end < pause:
            found[-1] = Piece(found[-1].start, frame + 1)
        else:
            found.append(Piece(frame, frame + 1))
    return usual, found
