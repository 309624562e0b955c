"""Sound at other speeds: what noise hides from the network at one may be plain at another."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from voz.audio import Samples


def at_speed(samples: Samples, speed: float) -> Samples:
    """Play samples faster by a factor, and higher by it: as if another had spoken."""
    import soxr  # takes 20 ms, and not every run needs it

    played: Samples = soxr.resample(samples, speed, 1.0)
    return played


def mean_odds(log_odds: Sequence[float]) -> float:
    """The logarithm of the mean of odds, from their logarithms."""
    return float(np.logaddexp.reduce(log_odds)) - math.log(len(log_odds))
