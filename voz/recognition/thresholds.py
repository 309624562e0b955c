"""The confidence that a command needs to be obeyed."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from voz.recognition.confidence import multiply_odds, sigmoid
from voz.recognition.confidence_model import Model
from voz.settings import Recognition


@dataclass(frozen=True)
class Thresholds:
    """The confidence that most commands need, and those that must not be missed, 0 to 1."""

    usual: float
    never_missed: float


def thresholds_of(model: Model, settings: Recognition) -> Thresholds:
    """Compute the thresholds; the arguments are those of `thresholds`."""
    if settings.threshold is not None:
        return Thresholds(settings.threshold, settings.threshold)
    usual = threshold_for(model, settings.false_alarms_per_hour or model.usual_alarms)
    return Thresholds(usual, multiply_odds(usual, 1 / settings.missed_cost))


def thresholds(model: Model, settings: Recognition, commands: Iterable[str]) -> dict[str, float]:
    """The threshold of each command by a model and settings, 0 to 1."""
    of = thresholds_of(model, settings)
    return {c: of.never_missed if c in settings.never_missed else of.usual for c in commands}


def threshold_for(model: Model, alarms: float) -> float:
    """The threshold, 0 to 1, for this many false alarms in an hour of talk, above 0."""
    return sigmoid(math.log(model.alarms / alarms) / model.alarms_fall)
