"""How sure a command must be to be obeyed: pure."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from voz.recognition.confidence import chance, with_odds
from voz.recognition.confidence_model import Model
from voz.settings import Recognition


@dataclass(frozen=True)
class Thresholds:
    """The confidence that any command needs, and one that must not be missed, 0 to 1."""

    usual: float
    never_missed: float


def thresholds_of(model: Model, settings: Recognition) -> Thresholds:
    """Compute the thresholds; the arguments are those of `thresholds`."""
    if settings.threshold is not None:
        return Thresholds(settings.threshold, settings.threshold)
    usual = threshold_for(model, settings.false_alarms_per_hour or model.usual_alarms)
    return Thresholds(usual, with_odds(usual, 1 / settings.missed_cost))


def thresholds(model: Model, settings: Recognition, commands: Iterable[str]) -> dict[str, float]:
    """Tell how sure each command must be: the less, the worse it is to miss it.

    Args:
        model: knows how many false alarms there are at each threshold.
        settings: how many there may be, and which commands must not be missed.
        commands: all sentences.

    Returns:
        A threshold from 0 to 1 for each command.
    """
    of = thresholds_of(model, settings)
    return {c: of.never_missed if c in settings.never_missed else of.usual for c in commands}


def threshold_for(model: Model, alarms: float) -> float:
    """Find the confidence that is needed for so few false alarms.

    Args:
        model: knows how many there are at each threshold.
        alarms: false alarms in an hour of people's talk, above 0.

    Returns:
        A threshold, 0 to 1.
    """
    return chance(math.log(model.alarms / alarms) / model.alarms_fall)
