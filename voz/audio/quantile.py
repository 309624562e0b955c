"""Quantiles, without the 5 MB of `numpy.ma` that numpy's own functions load."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def quantile(values: npt.ArrayLike, share: float) -> Any:
    """The value that a share (0 to 1) of some values is below, interpolated as numpy does it.

    Of more than one dimension it is taken along the first; there must be at least one value.
    """
    ordered = np.sort(np.asarray(values, np.float64), axis=0)
    place = share * (len(ordered) - 1)
    below = ordered[int(place)]
    above = ordered[min(int(place) + 1, len(ordered) - 1)]
    return below + (above - below) * (place - int(place))
