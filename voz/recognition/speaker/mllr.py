"""Fits the acoustic model to a speaker by a linear transform of its means (MLLR).

C. J. Leggetter, P. C. Woodland: Maximum likelihood linear regression for speaker adaptation of
continuous density hidden Markov models, Computer Speech & Language 9 (1995). One transform serves
all phones.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from voz.language.acoustic_model import CEPSTRA, FEATURE_STREAMS, AcousticModel, Floats
from voz.recognition.speaker.adaptation import Aligned, start_numbers

MLLR_PRIOR_FRAMES = 50
"""Weight of the unchanged means, frames."""

MIN_OCCUPANCY = 1e-3
"""Gaussians with a smaller share of a frame are left out."""

_NUMBER = re.compile(r"-?[0-9]{1,9}\.[0-9]{6}", re.ASCII)


class MeanTransform(NamedTuple):
    """Transforms the means of a stream: times `matrix` (13, 13), plus `bias` (13,)."""

    matrix: Floats
    bias: Floats


def fit_transforms(
    spoken: Sequence[tuple[Aligned, str]], model: AcousticModel
) -> tuple[MeanTransform, ...]:
    """Find the transform of each stream, by aligned sentences and their first cepstral means."""
    transforms = []
    for stream in range(FEATURE_STREAMS):
        means, variances = model.means[:, stream], model.variances[:, stream]
        usual = _extended(means.reshape(-1, CEPSTRA))
        spread = MLLR_PRIOR_FRAMES * usual.T @ usual / len(usual)
        # Not the mean: some variances are next to 0, and one of them would outweigh all the rest.
        precision = 1 / np.median(variances, axis=(0, 1))
        squares = precision[:, None, None] * spread
        products = precision[:, None] * spread[1:]
        for aligned, start in spoken:
            more_squares, more_products = _statistics(aligned, start, model, stream)
            squares += more_squares
            products += more_products
        rows = np.linalg.solve(squares, products[:, :, None])[:, :, 0]
        transforms.append(MeanTransform(rows[:, 1:], rows[:, 0]))
    return tuple(transforms)


def as_text(transforms: Sequence[MeanTransform]) -> str:
    """Write transforms as pocketsphinx reads them (`ps_mllr.c`), with unchanged variances."""
    lines = ["1", str(len(transforms))]  # of one class
    for matrix, bias in transforms:
        numbers = [*matrix, bias, np.ones(CEPSTRA)]
        lines += [str(CEPSTRA), *(" ".join(f"{n:.6f}" for n in row) for row in numbers)]
    return "\n".join(lines) + "\n"


def is_transforms(text: str) -> bool:
    """Whether a text is what `as_text` writes."""
    found = text.split()
    one = 1 + CEPSTRA * (CEPSTRA + 2)
    if found[:2] != ["1", str(FEATURE_STREAMS)] or len(found) != 2 + FEATURE_STREAMS * one:
        return False
    sizes, numbers = found[2::one], [n for at in range(one - 1) for n in found[3 + at :: one]]
    return {*sizes} == {str(CEPSTRA)} and all(map(_NUMBER.fullmatch, numbers))


def _statistics(
    aligned: Aligned, start: str, model: AcousticModel, stream: int
) -> tuple[Floats, Floats]:
    """The sums of a sentence for a stream, shapes (13, 14, 14) and (13, 14)."""
    heard = _streams(aligned.cepstra - start_numbers(start))[stream][aligned.at]
    means = model.means[aligned.phones, stream]
    variances = model.variances[aligned.phones, stream]
    weights = model.log_weights(aligned.senones)[stream]
    distances = ((heard[:, None] - means) ** 2 / variances + np.log(variances)).sum(axis=2)
    likely = weights - distances / 2
    shares = np.exp(likely - likely.max(axis=1, keepdims=True))
    shares /= shares.sum(axis=1, keepdims=True)
    frame, gaussian = np.nonzero(shares >= MIN_OCCUPANCY)
    precisions = shares[frame, gaussian, None] / variances[frame, gaussian]
    extended = _extended(means[frame, gaussian])
    squares = np.einsum("ni,nj,nk->ijk", precisions, extended, extended, optimize=True)
    products = np.einsum("ni,nj->ij", precisions * heard[frame], extended)
    return squares, products


def _streams(cepstra: Floats) -> tuple[Floats, Floats, Floats]:
    """The features of pocketsphinx (`1s_c_d_dd`), each of shape (n, 13)."""
    frames = np.arange(len(cepstra))

    def later(by: int) -> Floats:
        return cepstra[np.clip(frames + by, 0, len(cepstra) - 1)]

    return cepstra, later(2) - later(-2), later(3) - later(-1) - later(1) + later(-3)


def _extended(means: Floats) -> Floats:
    """Put a 1 before each mean, for the bias; shape (n, 14)."""
    return np.hstack([np.ones((len(means), 1)), means])
