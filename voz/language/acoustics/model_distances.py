"""Computes the distances between the phones of an acoustic model from its Gaussians. Does I/O.

Taking phone p for q costs the Kullback-Leibler divergence of their states: the log-likelihood that
a frame of p loses on average if q has to explain it. For the English model this correlates with
the measured distances by .86 (of the logarithms).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from voz.errors import LanguageError
from voz.language.acoustics.acoustic_model import (
    FEATURE_STREAMS,
    STATES_PER_PHONE,
    AcousticModel,
    Floats,
    Indices,
    read_durations,
    read_phones,
    spoken_phones,
)
from voz.language.acoustics.phone_distances import PhoneDistances

SAMPLED_FRAMES = 48
"""Frames for each state of a phone; four times as many change a distance by a few percent."""

MAX_FRAME_LOSS = 60.0
"""Nats; a single outlier says no more."""

DIVERGENCE_POWER = 0.75
"""From a divergence to a loss: a search aligns phones where they fit best. Fitted on English."""

COMMAND_STRETCH = 1.3
"""Phones of commands last longer than those of the read speech that models are trained on."""

DEFAULT_LOSS = 6.0
"""Nats per frame, for models with other kinds of Gaussians: the English mean."""

DEFAULT_FRAMES = 9.5


def compute_distances(folder: Path) -> PhoneDistances:
    """Compute the distances of a model's phones.

    All phones are equally far apart if they do not have a codebook each, as in a continuous model.

    Raises:
        LanguageError: there is no model in the folder.
    """
    names = read_phones(folder)
    phones = spoken_phones(names)
    try:
        model = AcousticModel(folder)
    except LanguageError:  # another kind of Gaussians
        loss: Floats = np.full((len(phones), len(phones)), DEFAULT_LOSS)
    else:
        loss = divergences(model, [model.phones[phone] for phone in phones]) ** DIVERGENCE_POWER
    np.fill_diagonal(loss, 0.0)
    lengths = dict(zip(names, COMMAND_STRETCH * _durations(folder, len(names)), strict=True))
    return PhoneDistances(
        {phone: round(float(lengths[phone]), 1) for phone in phones},
        {
            phone: {other: round(float(each), 1) for other, each in zip(phones, row, strict=True)}
            for phone, row in zip(phones, loss, strict=True)
        },
    )


def divergences(model: AcousticModel, phones: Sequence[int]) -> Floats:
    """Compute what a frame of each phone loses if another explains it.

    Returns:
        The losses in nats, shape (said, taken for).
    """
    chance = np.random.default_rng(0)
    numbers = np.array(phones)
    total = np.zeros((len(phones), len(phones)))
    for state in range(STATES_PER_PHONE):
        weights = model.log_weights(STATES_PER_PHONE * numbers + state)
        for stream in range(FEATURE_STREAMS):
            total += _lost(model, numbers, stream, weights[stream], chance)
    return total / STATES_PER_PHONE


def _lost(
    model: AcousticModel,
    phones: Indices,
    stream: int,
    log_weights: Floats,
    chance: np.random.Generator,
) -> Floats:
    """Return the losses in one stream of one state."""
    means, variances = model.means[phones, stream], model.variances[phones, stream]
    log_weights = log_weights - np.log(np.exp(log_weights).sum(axis=1, keepdims=True))
    shares = np.exp(log_weights)
    drawn = []
    for mean, variance, share in zip(means, variances, shares, strict=True):
        which = chance.choice(len(share), SAMPLED_FRAMES, p=share / share.sum())
        spread = np.sqrt(variance[which])
        drawn.append(mean[which] + spread * chance.standard_normal(spread.shape))
    frames = np.concatenate(drawn)
    likely = np.stack(
        [_log_likelihood(frames, *each) for each in zip(means, variances, log_weights, strict=True)]
    ).reshape(len(phones), len(phones), SAMPLED_FRAMES)  # taken for, said, frames
    own = likely[range(len(phones)), range(len(phones))]
    return np.asarray(np.minimum(own[:, None] - likely.swapaxes(0, 1), MAX_FRAME_LOSS).mean(axis=2))


def _log_likelihood(
    frames: Floats, means: Floats, variances: Floats, log_weights: Floats
) -> Floats:
    precisions = 1 / variances
    constant = log_weights - 0.5 * (
        np.log(2 * np.pi * variances).sum(axis=1) + (means**2 * precisions).sum(axis=1)
    )
    each = frames @ (means * precisions).T
    each -= frames**2 @ (0.5 * precisions).T
    each += constant
    best = each.max(axis=1)
    each -= best[:, None]
    # float32 is exact enough for a sum of shares, and most of the time goes into exp.
    return np.asarray(best + np.log(np.exp(each.astype(np.float32)).sum(axis=1)))


def _durations(folder: Path, phones: int) -> Floats:
    try:
        found = read_durations(folder)
    except LanguageError:
        found = np.array([])
    return found if len(found) == phones else np.full(phones, DEFAULT_FRAMES)
