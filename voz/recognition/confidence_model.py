"""The models that a confidence is computed by: what they hold, and their file."""

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
from voz.recognition.costs import Cost
from voz.records import CheckedRecord, Finite

MODEL = Path(__file__).with_name("confidence.json")

VOICES_AROUND = "voices around"
"""The one feature of one ear whose weight is not fitted, but was found in rooms by hand."""

POCKETSPHINX_FEATURES = ("phones", "worst word", "hurried", "not covered", "sound after")
SCORE = "score"
"""What the network gives a command, nats; see `second_ear`."""

NETWORK_FEATURES = (SCORE,)
"""The features that each model has."""

Positive = Annotated[float, msgspec.Meta(gt=0, le=1e12)]


class Model(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """A logistic model.

    Attributes:
        fitted_on: what it was made from, for the reader.
        intercept: the log-odds when all features are 0.
        weights: what one unit of each feature adds to the log-odds.
        alarms: how many false alarms there are in an hour of talk when everything above even odds
            is accepted.
        alarms_fall: the power of the odds with which they become fewer.
        usual_alarms: how many of them there may be in an hour, if nobody says otherwise.
        costs: the commands missed at several rates of them, which rise; empty if that is unknown.
    """

    fitted_on: list[str]
    intercept: Finite
    weights: dict[str, Finite]
    alarms: Positive
    alarms_fall: Positive
    usual_alarms: Positive = 0.5
    costs: tuple[Cost, ...] = ()


class Models(CheckedRecord, frozen=True, forbid_unknown_fields=True):
    """What a confidence is computed by, with the second ear and without it."""

    two_ears: Model
    one_ear: Model


def load_models(file: str | None = None) -> Models:
    """Read what `voz fit-confidence` wrote.

    Args:
        file: its name; without one, the models of the package.

    Raises:
        ConfigError: it cannot be read, is damaged or knows other features than voz does.
    """
    path, advice = Path(file or MODEL), "name what `voz fit-confidence` wrote"
    models = read_json(path, Models, ConfigError, advice, MAX_SETTINGS_BYTES)
    one_ear = {*POCKETSPHINX_FEATURES, VOICES_AROUND}
    for weights, known in (
        (models.one_ear.weights, one_ear),
        (models.two_ears.weights, {*NETWORK_FEATURES}),
    ):
        if strange := sorted(weights.keys() - known):
            what = f'"{strange[0]}" is no feature of this voz'
            raise ConfigError(f"{shown_path(path)}: cannot be used ({what}); {advice}")
    return models


def save_models(models: Models, path: Path) -> None:
    """Write models as readable JSON.

    Raises:
        ConfigError: the file cannot be written.
    """
    text = msgspec.json.format(msgspec.json.encode(models), indent=2).decode()
    with os_errors_as_config_error(path), atomic_write(path) as file:
        file.write(f"{text}\n")


def with_log_odds(model: Model, more: float) -> Model:
    """Trust a speaker more than others: add to the log-odds of every utterance."""
    return replace(model, intercept=model.intercept + more)
