"""Fits the confidence: a logistic model of labeled recordings."""

from __future__ import annotations

import logging
import math
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from voz.apps.evaluation.recognition_tasks import Task, assign_to_stretches, in_processes, tasks_for
from voz.apps.recordings.manifest import Clip
from voz.audio import SAMPLE_RATE
from voz.audio.sound_files import read_blocks
from voz.errors import AudioError, ConfigError
from voz.language.language_files import find_language
from voz.language.sentences.command_set import Commands
from voz.recognition.confidence import (
    NETWORK_FEATURES,
    POCKETSPHINX_FEATURES,
    VOICES_AROUND,
    Context,
    MissRate,
    Model,
    Models,
    alarm_rates_near,
    discount_for_context,
    load_models,
    probability,
)
from voz.recognition.decision import DecisionRule
from voz.recognition.engine import RecognitionEngine, candidates_in
from voz.recognition.thresholds import threshold_for
from voz.settings import Recognition

_log = logging.getLogger("voz")

TOO_LITTLE_TALK = (
    "the manifests need more recordings of the kind talk, half an hour or so, to tell how often it "
    "sounds like a command"
)


@dataclass(frozen=True)
class RecordingExamples:
    """What is in a recording; nothing if it cannot be read."""

    examples: list[Example]  # with the network
    alone: list[Example]  # by pocketsphinx alone
    talk: float  # s
    commands: list[Clip]  # those that are said in it


@dataclass(frozen=True)
class Example:
    """What is known of one utterance."""

    clip: Clip
    text: str  # the command that was heard
    features: dict[str, float]
    speech_probability: float  # how surely the sound is speech, 0 to 1
    context: Context
    right: bool  # whether it is what was said


def collect_examples(
    clips: Sequence[Clip], lm: str | None, processes: int | None
) -> Iterator[RecordingExamples]:
    """Recognize recordings and stretches of streams; yields the examples of each, in order.

    `lm` is the folder of the language files; `processes` None is one on each core.
    """
    tasks = tasks_for(clips, [], [], room=False)
    return in_processes(partial(_examples, lm=lm), tasks, processes)


def describe_set(clips: Iterable[Clip], name: str) -> str:
    """Count the recordings of each kind and the speakers of a set, in one line."""
    chosen = [clip for clip in clips if clip.set == name]
    kinds = Counter(clip.kind for clip in chosen)
    counts = ", ".join(f"{number} {kind}" for kind, number in sorted(kinds.items()))
    return f"{name}: {counts}; {len({clip.speaker for clip in chosen})} speakers"


def check_talk(clips: Iterable[Clip]) -> None:
    """Raise ConfigError if no recording is talk, before minutes of work."""
    if not any(clip.kind == "talk" for clip in clips):
        raise ConfigError(TOO_LITTLE_TALK)


@cache
def _recognizer(lm: str | None, network: bool) -> RecognitionEngine:
    return RecognitionEngine(find_language(lm), Recognition(use_network=network))


def _examples(task: Task, lm: str | None) -> RecordingExamples:
    """Recognize a recording; what is heard around the stretches of a stream counts as noise."""
    first = task.clips[0]
    try:
        blocks = list(read_blocks(first.path))
    except AudioError as error:
        _log.warning(str(error))
        return RecordingExamples([], [], 0.0, [])
    seconds = sum(map(len, blocks)) / SAMPLE_RATE
    stretches = [(clip.start or 0.0, clip.end or seconds) for clip in task.clips]
    surroundings = replace(first, kind="noise", speaker=first.file, condition="all")

    def heard(network: bool) -> list[Example]:
        found = list(candidates_in(_recognizer(lm, network), blocks))
        parts, rest = assign_to_stretches(found, stretches)
        return [
            Example(
                clip, o.text, o.features, o.speech_probability, o.context, _is_said(clip, o.text)
            )
            for clip, part in zip((*task.clips, surroundings), (*parts, rest), strict=True)
            for o in part
        ]

    talk = sum(b - a for c, (a, b) in zip(task.clips, stretches, strict=True) if c.kind == "talk")
    commands = [clip for clip in task.clips if clip.kind == "command"]
    return RecordingExamples(heard(network=True), heard(network=False), talk, commands)


def _is_said(clip: Clip, text: str) -> bool:
    return clip.kind == "command" and clip.text == text


RIDGE = 1.0
"""Pulls the weights towards 0 with the strength of one utterance."""

FOLDS = 5

SHUFFLES = 8
"""Divisions into folds that are averaged: the threshold from one alone is off by up to 0.1."""

LIKELIEST = 5
"""Stretches of talk that sound most like a command, from which the false alarms are estimated.

3 to 6 give a threshold for one alarm in two hours of .36 to .44. More reach into the bulk of talk,
where log-odds fall off more slowly than at the end: 8 give .48, 10 .53 and 15 .84, though none of
37 minutes is above .33.
"""

MAX_LOG_EXTRAPOLATION = 20.0
"""Largest logarithm of how many times more alarms are estimated at even odds than were heard."""

DEFAULT_ALARM_RATE_WITHOUT_NETWORK = 20.0
"""In an hour; so many single sentences of people it takes for commands where it obeys most."""

COMMAND_SHARE = 1 / 2
"""Of what is said near someone who drives a robot, so much are commands: the prior."""

Matrix = npt.NDArray[np.float64]


class Fitted(NamedTuple):
    """A model, and the `acceptance` by models that were fitted without the speakers."""

    model: Model
    accepted: dict[str, tuple[float, int]]


def fit_models(
    recordings: Sequence[RecordingExamples],
    fitted_on: list[str],
    commands: Commands,
    with_network: bool = True,
) -> tuple[Models, Fitted]:
    """Fit the models of pocketsphinx alone, and of it with the network, for a language.

    Args:
        recordings: have utterances, some of them right, some of them in talk.
        fitted_on: a description of them, which is written into the models.
        commands: those of the language.
        with_network: whether the network knows it.

    Returns:
        The models, and the one that judges the language.

    Raises:
        ConfigError: as `fit` and `with_alarms`.
    """
    said = [clip for recording in recordings for clip in recording.commands]
    hours = sum(recording.talk for recording in recordings) / 3600
    now = load_models()

    def fitted(some: Sequence[Example], names: Sequence[str], **given: Any) -> Fitted:
        likely = cross_validated(some, names)
        model = replace(with_alarms(fit(some, fitted_on, names), some, likely, hours), **given)
        model = with_costs(model, some, likely, said, commands)
        threshold = threshold_for(model, model.default_alarm_rate)
        return Fitted(model, acceptance(some, likely, threshold))

    alone = fitted(
        [example for recording in recordings for example in recording.alone],
        POCKETSPHINX_FEATURES,
        default_alarm_rate=DEFAULT_ALARM_RATE_WITHOUT_NETWORK,
    )
    # Recordings of one command do not show what voices in the room are worth.
    voices = {VOICES_AROUND: now.without_network.weights[VOICES_AROUND]}
    one = replace(alone.model, weights=alone.model.weights | voices)
    models = replace(now, without_network=one)
    if not with_network:
        return models, alone
    both = fitted(
        [example for recording in recordings for example in recording.examples], NETWORK_FEATURES
    )
    return replace(models, with_network=both.model), both


def fit(examples: Sequence[Example], fitted_on: list[str], names: Sequence[str]) -> Model:
    """Fit a model, without its false alarms; raises ConfigError if no example, or each, is right.

    Near-misses are not as frequent among recordings as in life, so both classes are weighed as if
    `COMMAND_SHARE` of all utterances were commands.
    """
    # What is no speech is refused for that, and would only distort the weights.
    examples = [example for example in examples if example.speech_probability > 0]
    right = np.array([example.right for example in examples])
    if right.all() or not right.any():
        raise ConfigError("the manifests need both commands that are understood and other speech")
    x = np.array([[example.features[name] for name in names] for example in examples])
    middle, spread = x.mean(axis=0), x.std(axis=0) + 1e-9
    share = right.mean()
    weights = np.where(right, COMMAND_SHARE / share, (1 - COMMAND_SHARE) / (1 - share))
    intercept, slopes = _logistic((x - middle) / spread, right.astype(float), weights)
    slopes = slopes / spread
    intercept -= float(slopes @ middle)
    return Model(
        fitted_on=fitted_on,
        intercept=round(intercept, 4),
        weights={name: round(float(w), 4) for name, w in zip(names, slopes, strict=True)},
        alarms=1.0,
        alarm_exponent=1.0,
    )


def with_alarms(
    model: Model, examples: Iterable[Example], probabilities: Iterable[float], hours: float
) -> Model:
    """Add to a model how often talk sounds like a command.

    Log-odds fall off exponentially at their upper end; the fall is estimated as Hill does it
    (1975, doi:10.1214/aos/1176343247). Talk in which the command was said is no false alarm.

    Args:
        model: the result of `fit`.
        examples: utterances, those in talk among them.
        probabilities: of each to be right, by models that were fitted without its speaker.
        hours: length of the talk, h.

    Raises:
        ConfigError: there is too little talk, or commands are said in it.
    """
    pairs = zip(examples, probabilities, strict=True)
    false = [
        (math.log(likely / (1 - likely)), example)
        for example, likely in pairs
        if example.clip.kind == "talk" and likely > 0 and not _is_in(example.text, example.clip)
    ]
    false.sort(key=lambda pair: pair[0], reverse=True)
    if len(false) <= LIKELIEST:
        raise ConfigError(TOO_LITTLE_TALK)
    likeliest, tail = false[:LIKELIEST], false[LIKELIEST][0]
    spread = sum(odds - tail for odds, _ in likeliest)
    if spread <= 0 or LIKELIEST * tail > MAX_LOG_EXTRAPOLATION * spread:
        raise ConfigError(_talk_is_too_sure([example for _, example in likeliest]))
    fall = LIKELIEST / spread
    # Where so many were seen, one more is to be expected, if every rate is as likely beforehand.
    alarms = (LIKELIEST + 1) / hours * math.exp(fall * tail)
    return replace(model, alarms=round(alarms, 4), alarm_exponent=round(fall, 4))


def _talk_is_too_sure(likeliest: Iterable[Example]) -> str:
    heard = ", ".join(f'"{example.text}" in {example.clip.file}' for example in likeliest)
    return (
        f"talk sounds as much like commands as commands do: {heard}; give the texts of such "
        "recordings in their manifest, or leave them out"
    )


def with_costs(
    model: Model,
    examples: Sequence[Example],
    probabilities: Sequence[float],
    said: Collection[Clip],
    commands: Commands,
) -> Model:
    """Add to the result of `with_alarms` the share of commands missed at several rates of alarms.

    `said` are the commands that were said, also those of which nothing was heard; examples and
    probabilities are as for `with_alarms`.
    """
    costs = []
    for alarms in alarm_rates_near(model.default_alarm_rate):
        rule = DecisionRule(commands, model, Recognition(false_alarms_per_hour=alarms))
        pairs = zip(examples, probabilities, strict=True)
        accepted = [example for example, likely in pairs if rule.accepts(example.text, likely)]
        right = {example.clip for example in accepted if example.right}
        right -= {example.clip for example in accepted if not example.right}
        missed = len(set(said) - right) / len(set(said))
        costs.append(MissRate(alarms, round(missed, 4)))
    return replace(model, costs=tuple(costs))


def cross_validated(examples: Sequence[Example], names: Sequence[str]) -> list[float]:
    """Return the probability of each example by models that were fitted without its speaker."""
    # One name is one speaker, in whatever set: clips may be heard again in rooms.
    speakers = sorted({e.clip.speaker for e in examples})
    rng = np.random.default_rng(0)
    # Shuffled, since neighbors in the alphabet come from the same source.
    orders = [rng.permutation(len(speakers)) for _ in range(SHUFFLES)]
    found = []
    for order in orders:
        fold_of = {s: int(place) % FOLDS for s, place in zip(speakers, order, strict=True)}
        folds = [fold_of[e.clip.speaker] for e in examples]
        found.append(_held_out(examples, folds, names))
    return [_mean_odds(likely) for likely in zip(*found, strict=True)]


def acceptance(
    examples: Iterable[Example], probabilities: Iterable[float], threshold: float
) -> dict[str, tuple[float, int]]:
    """Return the share accepted and the count, by set, kind, condition and whether it is right."""
    groups: dict[str, list[bool]] = {}
    for example, likely in zip(examples, probabilities, strict=True):
        clip = example.clip
        outcome = "right" if example.right else "wrong"
        name = f"{clip.set} {clip.kind} {clip.condition} {outcome}"
        groups.setdefault(name, []).append(likely >= threshold)
    return {name: (sum(v) / len(v), len(v)) for name, v in sorted(groups.items())}


def _logistic(x: Matrix, y: Matrix, weights: Matrix) -> tuple[float, Matrix]:
    """Fit a logistic regression by Newton's method; the intercept is not pulled to 0."""
    design = np.column_stack([np.ones(len(x)), x])
    ridge = np.full(design.shape[1], RIDGE)
    ridge[0] = 0
    beta = np.zeros(design.shape[1])
    for _ in range(100):
        p = 1 / (1 + np.exp(-np.clip(design @ beta, -700, 700)))
        gradient = design.T @ (weights * (y - p)) - ridge * beta
        curvature = (design * (weights * p * (1 - p))[:, None]).T @ design + np.diag(ridge + 1e-9)
        step = np.linalg.solve(curvature, gradient)
        beta += step
        if np.abs(step).max() < 1e-9:
            break
    return float(beta[0]), beta[1:]


def _held_out(
    examples: Sequence[Example], folds: Sequence[int], names: Sequence[str]
) -> list[float]:
    """Return the probability of each example by the model of the other folds."""
    models = [
        fit([e for e, f in zip(examples, folds, strict=True) if f != fold], [], names)
        for fold in range(FOLDS)
    ]
    return [_likely(models[fold], e) for e, fold in zip(examples, folds, strict=True)]


def _mean_odds(shares: Sequence[float]) -> float:
    """Average probabilities by their log-odds; what is 0 for one is 0 for all."""
    if min(shares) == 0:
        return 0.0
    mean = sum(math.log(share / (1 - share)) for share in shares) / len(shares)
    return 1 / (1 + math.exp(-mean))


def _likely(model: Model, example: Example) -> float:
    sure = example.speech_probability * probability(model, example.features)
    return discount_for_context(sure, example.context)


def _is_in(command: str, talk: Clip) -> bool:
    """Whether all words of a command are in what was said: `stop` is in `it stopped`."""
    said = talk.text.split()
    return all(any(word.startswith(one) for word in said) for one in command.split())
