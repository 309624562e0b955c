"""How likely it is that a command was said: pure, evidence in, probability out."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path as FilePath

import msgspec

from voz.errors import ConfigError
from voz.recognition.evidence import Evidence, Path, Span

MODEL = FilePath(__file__).with_name("confidence.json")

CLEAR_MARGIN = 2.0  # nats for each frame; a rival further behind is none
NO_SPEECH, SURE_SPEECH = 0.4, 0.6
"""Between these the voice detector is not sure: of what the end-pointer takes for speech, nine of
ten noises are below the first, and 99 of 100 commands above the second."""


class Model(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A logistic model.

    Attributes:
        fitted_on: what it was made from, for the reader.
        intercept: the log-odds when all features are 0.
        weights: what one unit of each feature adds to the log-odds.
    """

    fitted_on: list[str]
    intercept: float
    weights: dict[str, float]


def load_model(path: FilePath = MODEL) -> Model:
    """Read a model that `voz fit-confidence` wrote; without a path, the one of the package."""
    return msgspec.json.decode(path.read_bytes(), type=Model)


def save_model(model: Model, path: FilePath) -> None:
    """Write a model as readable JSON.

    Raises:
        ConfigError: the file cannot be written.
    """
    text = msgspec.json.format(msgspec.json.encode(model), indent=2).decode()
    try:
        path.write_text(f"{text}\n", encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written ({error.strerror})") from error


def features(evidence: Evidence, phones_in: Mapping[str, int]) -> dict[str, float]:
    """Bring the evidence to a few numbers that mean the same for any list of commands.

    Args:
        evidence: what speaks for the command and against it.
        phones_in: how many phones each word of the dictionary has.

    Returns:
        The features by name; likelihood ratios are in nats for each frame of speech.
    """
    command, phones = evidence.command, evidence.phones
    frames = max(1, sum(span.frames for span in phones.spans))
    covered = _covered(command, phones)
    pace = [span.frames / phones_in[span.name] for span in command.spans]
    rival = max(evidence.rivals.values(), default=-math.inf)
    return {
        "phones": (command.score - phones.score) / frames,
        "worst word": min(_ratio(span, phones) for span in command.spans),
        "rival": min(CLEAR_MARGIN, (command.score - rival) / frames),
        "not covered": 1 - covered / frames,
        "frames outside": math.log1p(frames - covered),
        "quickest word": math.log(min(pace)),
        "slowest word": math.log(max(pace)),
    }


def probability(model: Model, values: Mapping[str, float]) -> float:
    """Tell how likely it is that the command was said, if it was speech at all.

    Args:
        model: the weights.
        values: what `features` gave.

    Returns:
        Of so many utterances with such features this share is right.
    """
    log_odds = model.intercept + sum(w * values[name] for name, w in model.weights.items())
    return 1 / (1 + math.exp(-max(-700.0, log_odds)))


def trust_in_speech(voice: float) -> float:
    """Tell how far a sound is to be trusted to be speech.

    The likelihoods cannot tell: the phone loop explains a tap as badly as a command does.

    Args:
        voice: what the voice detector gave for the words, 0 to 1.

    Returns:
        A factor for the probability, 0 for no speech to 1.
    """
    return min(1.0, max(0.0, (voice - NO_SPEECH) / (SURE_SPEECH - NO_SPEECH)))


def _ratio(word: Span, phones: Path) -> float:
    """A word's log-likelihood ratio to the phones in its frames, nats for each frame."""
    against = sum(_overlap(word, span) * span.score / span.frames for span in phones.spans)
    return (word.score - against) / word.frames


def _covered(command: Path, phones: Path) -> int:
    """Frames of speech, as the phone loop has it, in which the command has a word too."""
    return sum(_overlap(word, span) for word in command.spans for span in phones.spans)


def _overlap(one: Span, other: Span) -> int:
    return max(0, min(one.end, other.end) - max(one.start, other.start) + 1)
