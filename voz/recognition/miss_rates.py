"""Which share of the commands is missed at a rate of false alarms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated

import msgspec

from voz.records import CheckedRecord, Fraction

RATE_MULTIPLES = (0.2, 0.5, 1.0, 2.0, 4.0, 10.0)
"""Examined rates, as multiples of the usual one."""


class MissRate(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """The share of commands that is missed at some false alarms in an hour of people's talk."""

    alarms: Annotated[float, msgspec.Meta(gt=0, le=1e4)]
    missed: Fraction


def alarm_rates_near(usual: float) -> tuple[float, ...]:
    """The examined rates, from a fifth to ten times the usual one."""
    return tuple(round(usual * part, 4) for part in RATE_MULTIPLES)


def miss_rate_at(costs: Sequence[MissRate], alarms: float) -> float | None:
    """The share of commands that is missed at a rate of false alarms.

    Args:
        costs: known miss rates, by rising alarms.
        alarms: an hour; its logarithm is interpolated.

    Returns:
        None outside the known rates.
    """
    for one in costs:
        if one.alarms == alarms:
            return one.missed
    for one, other in pairwise(costs):
        if one.alarms < alarms < other.alarms:
            part = math.log(alarms / one.alarms) / math.log(other.alarms / one.alarms)
            return one.missed + part * (other.missed - one.missed)
    return None
