"""The files of an acoustic model, and the distances between its phones. Does I/O."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from voz.errors import LanguageError
from voz.files import read_bytes
from voz.language.phones import PhoneDistances

CEPSTRA = 13
"""Coefficients of a frame, in each stream."""

FEATURE_STREAMS = 3

STATES_PER_PHONE = 3
"""Senones of a phone; those of phones without context come first."""

VARIANCE_FLOOR = 1e-4
"""pocketsphinx's own `varfloor`."""

WEIGHT_UNIT = 1024 * np.log(1.0001)
"""One unit of `sendump`, nats: negative 1.0001-logarithms, shifted right by 10 bits."""

BINARY_MDEF_MAGIC = 0x46444D42
"""`BMDF`, the first bytes of a binary mdef."""

MAX_SELF_TRANSITION = 0.95
"""Probability; silence repeats forever."""

SILENCE_PHONE = "SIL"

BYTE_ORDER = 0x11223344
"""The first word of a little-endian file."""

MODEL_ADVICE = "give a folder in the format of CMUSphinx, or install pocketsphinx again"

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


def read_phones(folder: Path) -> list[str]:
    """Read the names of a model's phones, in the order of their codebooks, with `SIL`.

    Raises:
        LanguageError: the file is missing or is not part of a model.
    """
    try:
        data = read_model_file(folder, "mdef")
        return _text_phones(data) if data.startswith(b"0.3") else _binary_phones(data)
    except (ValueError, OverflowError, struct.error) as error:
        raise unusable_model(folder, error) from error


def read_model_file(folder: Path, name: str) -> bytes:
    """Read one of the files of a model; raises LanguageError."""
    return read_bytes(folder / name, LanguageError, MODEL_ADVICE)


def spoken_phones(phones: Iterable[str]) -> list[str]:
    """Leave out silence and noises, such as `SIL` and `+SPN+`."""
    return [phone for phone in phones if phone != SILENCE_PHONE and not phone.startswith("+")]


def unusable_model(folder: Path, why: object) -> LanguageError:
    """The error for a model that cannot be used."""
    return LanguageError(f"{folder}: the acoustic model cannot be used ({why})", MODEL_ADVICE)


class AcousticModel:
    """The Gaussians of a model whose phones have a codebook each.

    Attributes:
        means: of the Gaussians, shape (phones, streams, Gaussians, 13).
        variances: of the Gaussians, same shape.
        phones: the number of each phone by its name.
        weights: of the Gaussians, as the file has them: shape (streams, Gaussians, senones).
    """

    def __init__(self, folder: Path) -> None:
        """Read the model in a folder.

        Raises:
            LanguageError: a file is missing, or phones do not have a codebook each.
        """
        try:
            names = read_phones(folder)
            self.means = _read_gaussians(read_model_file(folder, "means"))
            variances = _read_gaussians(read_model_file(folder, "variances"))
            self.weights = _read_weights(read_model_file(folder, "sendump"), self.means.shape[2])
            if not len(names) == len(self.means) == len(variances):
                raise ValueError("another number of phones in mdef than in means")
        except (ValueError, OverflowError, struct.error) as error:
            raise unusable_model(folder, error) from error
        self.variances = np.maximum(variances, VARIANCE_FLOOR)
        self.phones = {name: number for number, name in enumerate(names)}

    def log_weights(self, senones: Indices) -> Floats:
        """Log weights of senones, shape (streams, n, Gaussians)."""
        return np.asarray(-WEIGHT_UNIT * self.weights[:, :, senones].transpose(0, 2, 1))


def read_durations(folder: Path) -> Floats:
    """Read how many frames each phone lasts on average; raises LanguageError."""
    try:
        data = read_model_file(folder, "transition_matrices")
        at = _behind_header(data)
        order, phones, states, targets = struct.unpack_from("<I3i", data, at)
        if order != BYTE_ORDER or (states, targets) != (STATES_PER_PHONE, STATES_PER_PHONE + 1):
            raise ValueError("transition matrices of another kind")
        counts = _numbers(data, phones * states * targets, at + 20)
    except (ValueError, OverflowError, struct.error) as error:
        raise unusable_model(folder, error) from error
    matrices = counts.reshape(phones, states, targets).astype(np.float64)
    stays = matrices[:, range(STATES_PER_PHONE), range(STATES_PER_PHONE)] / np.maximum(
        matrices.sum(axis=2), 1e-9
    )
    return np.asarray((1 / (1 - np.minimum(stays, MAX_SELF_TRANSITION))).sum(axis=1))


def _text_phones(data: bytes) -> list[str]:
    lines = (line.split() for line in data.decode().splitlines())
    names = [line[0] for line in lines if len(line) > 5 and line[1:4] == ["-", "-", "-"]]
    if not names:
        raise ValueError("no phones in mdef")
    return names


def _binary_phones(data: bytes) -> list[str]:
    mark, version, description = struct.unpack_from("<3i", data)
    if mark != BINARY_MDEF_MAGIC or version != 1:
        raise ValueError("mdef of another kind")
    sizes = 12 + description
    (phones,) = struct.unpack_from("<i", data, sizes)
    names = data[sizes + 10 * 4 :].split(b"\0", phones)[:phones]
    return [name.decode("ascii") for name in names]


def _behind_header(data: bytes) -> int:
    mark = b"endhdr\n"
    return data.index(mark) + len(mark)


def _numbers(data: bytes, count: int, at: int) -> npt.NDArray[np.float32]:
    """Return the 32-bit floats from a position on; raises ValueError if they are not there."""
    if not 0 < 4 * count <= len(data) - at:
        raise ValueError("another number of values than it claims")
    found = np.frombuffer(data, "<f4", count, at)
    if not np.isfinite(found).all():
        raise ValueError("values that are no numbers")
    return found


def _read_gaussians(data: bytes) -> Floats:
    """Return an array of shape (phones, streams, Gaussians, 13)."""
    at = _behind_header(data)
    order, phones, streams, gaussians = struct.unpack_from("<I3i", data, at)
    lengths = struct.unpack_from(f"<{streams}i", data, at + 16)
    if order != BYTE_ORDER or lengths != (CEPSTRA,) * FEATURE_STREAMS:
        raise ValueError("Gaussians of another kind")
    floats = phones * streams * gaussians * CEPSTRA
    numbers = _numbers(data, floats, at + 16 + 4 * streams + 4)
    return numbers.reshape(phones, streams, gaussians, CEPSTRA).astype(np.float64)


def _read_weights(data: bytes, gaussians: int) -> npt.NDArray[np.uint8]:
    """Return an array of shape (streams, Gaussians, senones)."""
    at = 0
    while length := struct.unpack_from("<I", data, at)[0]:  # texts, then an empty one
        at += 4 + length
    rows, senones = struct.unpack_from("<2i", data, at + 4)
    if rows != gaussians:
        raise ValueError("sendump of another kind")
    count = FEATURE_STREAMS * rows * senones
    return np.frombuffer(data, np.uint8, count, at + 12).reshape(FEATURE_STREAMS, rows, senones)


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

    Taking phone p for q costs the Kullback-Leibler divergence of their states: the log-likelihood
    that a frame of p loses on average if q has to explain it. For the English model this
    correlates with the measured distances by .86 (of the logarithms).

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
