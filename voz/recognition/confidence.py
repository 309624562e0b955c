"""The probability that a command was said, and its models."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import Enum
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec.structs import replace

from voz.errors import ConfigError
from voz.files import (
    MAX_SETTINGS_BYTES,
    atomic_write,
    os_errors_as_config_error,
    read_json,
    shown_path,
)
from voz.records import CheckedRecord, Finite, Fraction

DEFAULT_MODELS = Path(__file__).with_name("confidence.json")

VOICES_AROUND = "voices around"
"""The one feature whose weight is set by hand."""

POCKETSPHINX_FEATURES = ("phones", "worst word", "hurried", "not covered", "sound after")
SCORE = "score"
"""The score of the network, nats."""

NETWORK_FEATURES = (SCORE,)

Positive = Annotated[float, msgspec.Meta(gt=0, le=1e12)]


class Model(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """A logistic model."""

    fitted_on: list[str]  # the data, for the reader
    intercept: Finite  # log-odds when all features are 0
    weights: dict[str, Finite]  # log-odds for one unit of each feature
    alarms: Positive  # false alarms in an hour of talk, if all above even odds is accepted
    alarm_exponent: Positive  # the power of the odds with which they become fewer
    default_alarm_rate: Positive = 0.5  # default of `false_alarms_per_hour`
    costs: tuple[MissRate, ...] = ()  # by rising alarms; empty if unknown


class Models(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """The models with the network and without it."""

    with_network: Model
    without_network: Model


def load_models(file: str | None = None) -> Models:
    """Read what `voz fit-confidence` wrote, or the models of voz; raises ConfigError."""
    path, advice = Path(file or DEFAULT_MODELS), "name what `voz fit-confidence` wrote"
    models = read_json(path, Models, ConfigError, advice, MAX_SETTINGS_BYTES)
    of_pocketsphinx = {*POCKETSPHINX_FEATURES, VOICES_AROUND}
    for weights, known in (
        (models.without_network.weights, of_pocketsphinx),
        (models.with_network.weights, {*NETWORK_FEATURES}),
    ):
        if strange := sorted(weights.keys() - known):
            what = f'"{strange[0]}" is no feature of this voz'
            raise ConfigError(f"{shown_path(path)}: cannot be used ({what}); {advice}")
    return models


def save_models(models: Models, path: Path) -> None:
    """Write models as readable JSON; raises ConfigError if that fails."""
    text = msgspec.json.format(msgspec.json.encode(models), indent=2).decode()
    with os_errors_as_config_error(path), atomic_write(path) as file:
        file.write(f"{text}\n")


def with_log_odds(model: Model, more: float) -> Model:
    """Add to the log-odds of every utterance."""
    return replace(model, intercept=model.intercept + more)


NOISE_VOICE, SPEECH_VOICE = 0.5, 0.65
"""Outputs of the voice detector: 97 of 100 noises are below the first, 95 of 100 commands above the
second.
"""

SURE_PROBABILITY, SOFT_SPEECH_VOICE = 0.9, 0.2
"""A command of this probability needs only this voice: `up` and `off` are short and soft."""


class Context(Enum):
    """What is within 0.6 s of a command; its odds are divided by the value."""

    QUIET = 1.0
    UNKNOWN_AFTER = 8.0
    SPEECH = 12.0


def probability(model: Model, features: Mapping[str, float]) -> float:
    """The probability of the command by its features, provided that the sound is speech."""
    return sigmoid(model.intercept + sum(w * features[name] for name, w in model.weights.items()))


def speech_probability(voice: float, known: float = 0.0) -> float:
    """A factor from 0 to 1 for how surely a sound is speech, which likelihoods do not show.

    `voice` is what the voice detector gives for the words, `known` the probability of the command
    by the network, both 0 to 1.
    """
    if known >= SURE_PROBABILITY and voice >= SOFT_SPEECH_VOICE:
        return 1.0
    return min(1.0, max(0.0, (voice - NOISE_VOICE) / (SPEECH_VOICE - NOISE_VOICE)))


RIVAL_LEAD, OTHER_RIVAL_LEAD, ODDS_PER_RIVAL_NAT = 2.5, 4.5, 3.0
"""The lead of a rival word, nats, at which command and rival are as likely, in a command of
well-known words and in another, and how the log-odds fall with it (`benchmarks/neighbors.py`). It
is not 0: more commands are said than what is next to them."""

OTHER_LANGUAGE_RIVAL_LEAD = 5.0
"""The same in another language than English, in which the network is less sure."""

WELL_KNOWN_WORDS = (
    "arm back beer cocacola down fold forward go left point right rotate slow speech speed start "
    "stop turn up"
)
"""Those of voz's own list, which many voices taught the network. It hears the phones of others less
surely: a lead of 2.5 nats refuses 35 of 231 commands of other lists, one of 4.5 nats 19."""

WELL_KNOWN = frozenset(WELL_KNOWN_WORDS.split())


def own_word_probability(text: str, lead: float | None, *, is_english: bool = True) -> float:
    """The probability that a command was said and not one with a rival word in it.

    `lead` is how much better the best rival fits, nats; None if the command has none.
    """
    if lead is None:
        return 1.0
    if not is_english:
        limit = OTHER_LANGUAGE_RIVAL_LEAD
    else:
        limit = RIVAL_LEAD if WELL_KNOWN.issuperset(text.split()) else OTHER_RIVAL_LEAD
    return sigmoid(ODDS_PER_RIVAL_NAT * (limit - lead))


USUAL_GAP, ODDS_PER_GAP_SECOND, SUREST_WITH_GAP = 0.2, 20.0, 0.99
"""In other speech the phones of a command stand in their order by chance, far apart: above the
first time (s) without a phone within a word the log-odds fall by the second for each second, from
the third at most. Of 1,130 commands in six languages half have a gap of 0.12 s, 99 in 100 one of
0.27 s at most; of 18 false alarms in prompts, 15 have 0.24 s or more
(`benchmarks/results/languages.md`)."""


def discount_for_gap(confidence: float, gap: float) -> float:
    """The confidence with the longest time (s) without a phone within a word, from that without."""
    if gap <= USUAL_GAP:
        return confidence
    against = ODDS_PER_GAP_SECOND * (gap - USUAL_GAP)
    return multiply_odds(min(confidence, SUREST_WITH_GAP), math.exp(-against))


def discount_for_context(confidence: float, context: Context) -> float:
    """The confidence in a context, from that in a quiet one."""
    return multiply_odds(confidence, 1 / context.value)


def multiply_odds(share: float, factor: float) -> float:
    """Multiply the odds of a probability."""
    more = share * factor
    return more / (more + (1 - share))  # so bracketed, never above 1


def sigmoid(log_odds: float) -> float:
    """The probability of log-odds."""
    return 1 / (1 + math.exp(-min(700.0, max(-700.0, log_odds))))


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
    """The share of commands missed at a rate of false alarms an hour; None outside known rates.

    Between two known rates their logarithm is interpolated.
    """
    for one in costs:
        if one.alarms == alarms:
            return one.missed
    for one, other in pairwise(costs):
        if one.alarms < alarms < other.alarms:
            part = math.log(alarms / one.alarms) / math.log(other.alarms / one.alarms)
            return one.missed + part * (other.missed - one.missed)
    return None
