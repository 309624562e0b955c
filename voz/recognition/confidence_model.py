"""The models of the confidence, and their file."""

from __future__ import annotations

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
from voz.recognition.miss_rates import MissRate
from voz.records import CheckedRecord, Finite

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
    alarms_fall: Positive  # the power of the odds with which they become fewer
    usual_alarms: Positive = 0.5  # default of `false_alarms_per_hour`
    costs: tuple[MissRate, ...] = ()  # by rising alarms; empty if unknown


class Models(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """The models with the network and without it."""

    two_ears: Model  # with the network
    one_ear: Model


def load_models(file: str | None = None) -> Models:
    """Read what `voz fit-confidence` wrote, or the models of voz; raises ConfigError."""
    path, advice = Path(file or DEFAULT_MODELS), "name what `voz fit-confidence` wrote"
    models = read_json(path, Models, ConfigError, advice, MAX_SETTINGS_BYTES)
    of_pocketsphinx = {*POCKETSPHINX_FEATURES, VOICES_AROUND}
    for weights, known in (
        (models.one_ear.weights, of_pocketsphinx),
        (models.two_ears.weights, {*NETWORK_FEATURES}),
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
