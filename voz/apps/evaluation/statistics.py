"""Confidence intervals, and whether two figures differ. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec
import numpy as np

BOOTSTRAP_SAMPLES = 1000
"""With so many the ends of the interval are right to a few thousandths."""

BOOTSTRAP_SEED = 1

INTERVAL_TAIL = 0.025
"""Probability beyond each end of a 95 % interval."""


class Estimate(msgspec.Struct, frozen=True):
    """A figure with its 95 % confidence interval."""

    value: float
    low: float
    high: float


class AlarmRate(msgspec.Struct, frozen=True):
    """How often something was obeyed that nobody said."""

    alarms: int
    hours: float
    per_hour: Estimate


def estimate(counts: Sequence[float], of: Sequence[float], speakers: Sequence[str]) -> Estimate:
    """Return a share or a rate with its interval: the percentile bootstrap over the speakers.

    Where there is one speaker it is over the clips, and says nothing about other speakers. Where
    all clips agree it has no width; that is no proof.

    Args:
        counts: for each clip, what is counted: 1 if it is right, its word errors, ...
        of: for each clip, what it is counted of: 1, its words, its hours, ...; the sum is not 0.
        speakers: for each clip, who speaks.
    """
    numbers = {speaker: number for number, speaker in enumerate(dict.fromkeys(speakers))}
    if len(numbers) > 1:
        which = [numbers[speaker] for speaker in speakers]
        above, below = np.bincount(which, weights=counts), np.bincount(which, weights=of)
    else:
        above, below = np.asarray(counts, float), np.asarray(of, float)
    groups = len(above)
    value = float(above.sum() / below.sum())
    rng = np.random.default_rng(BOOTSTRAP_SEED)
    drawn = rng.multinomial(groups, np.full(groups, 1 / groups), size=BOOTSTRAP_SAMPLES)
    low, high = np.percentile((drawn @ above) / (drawn @ below), [2.5, 97.5])
    return Estimate(_rounded(value), _rounded(min(low, value)), _rounded(max(high, value)))


def alarm_rate(alarms: int, hours: float) -> AlarmRate:
    """Return the rate of alarms in so many hours, above 0, with its exact Poisson interval.

    Garwood 1936, Biometrika 28, doi:10.1093/biomet/28.3-4.437.
    """
    low = _mean_for(alarms - 1, 1 - INTERVAL_TAIL) if alarms else 0.0
    ends = (alarms / hours, low / hours, _mean_for(alarms, INTERVAL_TAIL) / hours)
    return AlarmRate(alarms, round(hours, 4), Estimate(*map(_rounded, ends)))


def mcnemar(only_first: int, only_second: int) -> float:
    """Return the two-sided p-value of McNemar's exact test.

    The counts are of clips that one engine alone has right.
    """
    discordant = only_first + only_second
    ways = tail = 1  # math.comb(discordant, wins), which takes seconds for thousands of wins
    for wins in range(1, min(only_first, only_second) + 1):
        ways = ways * (discordant - wins + 1) // wins
        tail += ways
    return float(min(1.0, 2 * tail / 2**discordant))


def _mean_for(most: int, probability: float) -> float:
    """Find the mean of a Poisson count that is at most so many with this probability."""
    counts = np.arange(most + 1)
    log_factorials = np.cumsum(np.log(np.maximum(counts, 1)))
    low, high = 0.0, most + 10 * math.sqrt(most + 1) + 10
    for _ in range(60):  # halvings: as exact as a float
        middle = (low + high) / 2
        # By logarithms, so that no term overflows.
        terms = np.exp(counts * math.log(middle) - middle - log_factorials)
        if terms.sum() > probability:
            low = middle
        else:
            high = middle
    return low


def _rounded(value: float) -> float:
    return round(float(value), 5)
