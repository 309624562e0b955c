"""All thresholds by which recognition decides, in one table.

| what | is accepted from | threshold |
|---|---|---|
| a command, at the end of a segment | a confidence | `thresholds_of`, by false alarms an hour |
| `stop`, or another one of `never_missed` | a lower confidence | the same, by `missed_cost` |
| an answer that is waited for | a lower confidence | `ANSWER_ODDS_FACTOR` |
| a refused command that the robot may ask about | a lower confidence | `ASK_BACK_ODDS_FACTOR` |
| a command with another meaning close to it | a share | `MIN_MEANING_SHARE` |
| the robot's name | a confidence | `NAME_THRESHOLD` |
| a command after the name | a score | `MIN_SCORE_AFTER_NAME` |
| `stop`, spotted amid other sound | a score | `MIN_SPOTTING_SCORE` |
| `stop`, spotted over a reply | scores of several windows | `MIN_PLAYBACK_SCORES` |
| `stop`, settled over a reply | a score and a level | `STOP_LIMITS` |
| another command over a reply | a higher score and level | `COMMAND_LIMITS` |
| a command that a reply may have said | a score | `MIN_SCORE_WITHIN` |
| `stop`, without the network | a lead of another command | `NEVER_MISSED_TOLERANCE` |
| the same | a share of the speech that the other covers | `MIN_COVERAGE` |

A confidence or share is from 0 to 1; scores are those of the network, nats.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from voz.recognition.confidence import Model, multiply_odds, sigmoid
from voz.settings import Recognition

ANSWER_ODDS_FACTOR = 4.0
"""An answer that is waited for may have lower odds than a command by this factor."""

ASK_BACK_ODDS_FACTOR = 3.0
"""The robot asks back where the odds are lower than they need to be by this factor at most."""

MIN_MEANING_SHARE = 0.66
"""A sentence is refused that has less than this share among those of other meanings."""

NAME_THRESHOLD = 0.45
"""The confidence that the robot's name needs."""

MIN_SCORE_AFTER_NAME = 4.0
"""Score of a command that was nearly surely said after the name; with less the name is alone."""

MIN_SPOTTING_SCORE = 8.0
"""A command with a higher score may have been said; the robot halts before it is settled."""

MIN_PLAYBACK_SCORES = {2: 6.0, 3: 4.5}
"""Least mean score of a command that is found in 2 or in 3 windows of sound."""


class PlaybackLimits(NamedTuple):
    """What a command needs that is said while the robot speaks."""

    score: float  # least score without the phones of the reply, nats
    level: float  # least level above the usual residue of the echo, dB


STOP_LIMITS = PlaybackLimits(6.0, 0.0)
COMMAND_LIMITS = PlaybackLimits(8.0, 3.0)

MIN_SCORE_WITHIN = -5.0
"""Score above which a command may be among other words; those that are there have 4 and more."""

NEVER_MISSED_TOLERANCE = 1.1
"""A command that must not be missed wins although it is worse by this, nats per frame."""

MIN_COVERAGE = 0.75
"""Its words must cover this share of the speech that the better command covers."""


@dataclass(frozen=True)
class Thresholds:
    """The confidence that most commands need, and those that must not be missed, 0 to 1."""

    usual: float
    never_missed: float


def thresholds_of(model: Model, settings: Recognition) -> Thresholds:
    """The thresholds by a model and settings."""
    if settings.threshold is not None:
        return Thresholds(settings.threshold, settings.threshold)
    usual = threshold_for(model, settings.false_alarms_per_hour or model.default_alarm_rate)
    return Thresholds(usual, multiply_odds(usual, 1 / settings.missed_cost))


def asked_from(threshold: float) -> float:
    """The confidence from which on the robot asks back, by the one that a command needs."""
    return multiply_odds(threshold, 1 / ASK_BACK_ODDS_FACTOR)


def threshold_for(model: Model, alarms: float) -> float:
    """The threshold, 0 to 1, for this many false alarms in an hour of talk, above 0."""
    return sigmoid(math.log(model.alarms / alarms) / model.alarm_exponent)
