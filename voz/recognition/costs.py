"""What a rate of false alarms costs: the commands that are missed at it. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated

import msgspec

from voz.records import CheckedRecord, Fraction

AROUND = (0.2, 0.5, 1.0, 2.0, 4.0, 10.0)
"""Rates that are looked at, as parts of the usual one."""


class Cost(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """What one rate of false alarms costs.

    Attributes:
        alarms: in an hour of people's talk.
        missed: share of the commands that are not understood, or not surely enough.
    """

    alarms: Annotated[float, msgspec.Meta(gt=0, le=1e4)]
    missed: Fraction


def rates_around(usual: float) -> tuple[float, ...]:
    """Choose the rates that are looked at, from a fifth of the usual one to its tenfold."""
    return tuple(round(usual * part, 4) for part in AROUND)


def missed_at(costs: Sequence[Cost], alarms: float) -> float | None:
    """Tell what share of the commands is missed at a rate.

    Args:
        costs: what is known, of rising rates.
        alarms: the rate; between two that are known, the share is on the line between them, the
            rates taken by their logarithms.

    Returns:
        None if the rate is none of those nor between them.
    """
    for one in costs:
        if one.alarms == alarms:
            return one.missed
    for one, other in pairwise(costs):
        if one.alarms < alarms < other.alarms:
            part = math.log(alarms / one.alarms) / math.log(other.alarms / one.alarms)
            return one.missed + part * (other.missed - one.missed)
    return None
