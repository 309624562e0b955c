"""The files of an acoustic model: phones, Gaussians, weights, durations. Does I/O.

A phone has a codebook of Gaussians for each of three feature streams: the cepstra and their first
and second differences in time. Each state of a phone, a senone, weights the Gaussians in its own
way. The formats are those of pocketsphinx's `ms_gauden.c`, `ptm_mgau.c`, `tmat.c`, `mdef.c` and
`bin_mdef.c`, little-endian.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from voz.errors import LanguageError
from voz.files import read_bytes

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
            self._weights = _read_weights(read_model_file(folder, "sendump"), self.means.shape[2])
            if not len(names) == len(self.means) == len(variances):
                raise ValueError("another number of phones in mdef than in means")
        except (ValueError, OverflowError, struct.error) as error:
            raise unusable_model(folder, error) from error
        self.variances = np.maximum(variances, VARIANCE_FLOOR)
        self.phones = {name: number for number, name in enumerate(names)}

    def log_weights(self, senones: Indices) -> Floats:
        """Log weights of senones, shape (streams, n, Gaussians)."""
        return np.asarray(-WEIGHT_UNIT * self._weights[:, :, senones].transpose(0, 2, 1))

    def expected(self, phones: Indices, senones: Indices) -> Floats:
        """Return the mean cepstra of n states by their phones and senones, shape (n, 13).

        They are relative to the mean of an utterance.
        """
        weights = np.exp(self.log_weights(senones)[0])
        means = self.means[phones, 0]
        return np.asarray(np.einsum("ng,ngc->nc", weights, means) / weights.sum(1)[:, None])


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
