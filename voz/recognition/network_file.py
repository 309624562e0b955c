"""The file of the phoneme network."""

from __future__ import annotations

import math
import os
import stat
import zipfile
from pathlib import Path
from typing import IO, Any, NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from voz.files import atomic_write, open_to_read, sha256, shown_path

Floats = npt.NDArray[np.float32]

DEFAULT_NETWORK = Path(__file__).with_name("phonemes.npz")
"""The network of voz; `training/` makes such files."""

DESCRIPTION = "description"
"""Entry with the `Description` in JSON, as bytes."""

FINGERPRINT_DIGITS = 12

READ_BYTES = 65_536

MAX_NETWORK_BYTES = 64_000_000
"""Of a file, and of what it unpacks to; the network of voz has 4 million."""


class UnknownNetworkError(Exception):
    """There is no such file, or voz cannot compute the network in it."""


class Description(msgspec.Struct, forbid_unknown_fields=True):
    """What a file of weights says of itself; the symbols are IPA with `<wb>` and `<blank>` last."""

    symbols: list[str]
    origin: str
    licence: str


class NetworkFile(NamedTuple):
    """The tensors of a file by name, as in `training/network.py`, and what identifies the file."""

    weights: dict[str, Floats]
    description: Description
    fingerprint: str


def read_network(path: Path) -> NetworkFile:
    """Read a `.npz` file with an entry for each tensor; raises UnknownNetworkError."""
    try:
        with open_to_read(path) as file:
            weights = _read_arrays(file)
            if DESCRIPTION not in weights:
                raise ValueError("it has no description")
            description = msgspec.json.decode(weights.pop(DESCRIPTION).tobytes(), type=Description)
            for name, tensor in weights.items():
                # One after the other: all of them in both precisions would take 4 MB more.
                weights[name] = _finite(name, tensor)
            file.seek(0)
            identity = fingerprint(file)
    except Exception as error:  # of a broken archive there are many kinds
        why = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise UnknownNetworkError(
            f"{shown_path(path)}: holds no phoneme network ({why})"
        ) from error
    return NetworkFile(weights, description, identity)


def _read_arrays(file: IO[bytes]) -> dict[str, npt.NDArray[Any]]:
    """Read an `.npz` file, nothing of which is made before its size is known; raises ValueError."""
    status = os.fstat(file.fileno())
    if not stat.S_ISREG(status.st_mode):
        raise ValueError("it is no regular file")
    with zipfile.ZipFile(file) as archive:
        entries = archive.infolist()
        if max(status.st_size, sum(entry.file_size for entry in entries)) > MAX_NETWORK_BYTES:
            raise ValueError(f"it is larger than {MAX_NETWORK_BYTES:,} bytes")
        return {
            entry.filename.removesuffix(".npy"): _read_array(archive, entry) for entry in entries
        }


def _read_array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> npt.NDArray[Any]:
    """Read an entry of numbers whose header fits its size."""
    read_header = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }
    with archive.open(entry) as content:
        version = np.lib.format.read_magic(content)
        if version not in read_header:
            raise ValueError(f"{entry.filename} is of version {version}")
        shape, columns_first, kind = read_header[version](content)
        size = entry.file_size - content.tell()
        if kind.kind not in "fu" or min(shape, default=1) < 1:
            raise ValueError(f"{entry.filename} holds no numbers")
        if math.prod(shape) * kind.itemsize != size:
            raise ValueError(f"{entry.filename} has another size than it claims")
        numbers = np.frombuffer(content.read(), kind)
    return numbers.reshape(shape, order="F" if columns_first else "C")


def _finite(name: str, tensor: npt.NDArray[Any]) -> Floats:
    with np.errstate(over="ignore"):  # of 64 bits
        numbers: Floats = tensor.astype(np.float32)
    if not np.isfinite(numbers).all():
        raise ValueError(f"{name} holds what is no number")
    return numbers


def write_network(path: Path, weights: dict[str, Floats], description: Description) -> None:
    """Write a file of weights, in half precision."""
    entries: dict[str, Any] = {name: tensor.astype(np.float16) for name, tensor in weights.items()}
    entries[DESCRIPTION] = np.frombuffer(msgspec.json.encode(description), np.uint8)
    with atomic_write(path, "wb") as file:  # who is killed meanwhile keeps the old one
        np.savez(file, **entries)


def fingerprint_of(file: str | None = None) -> str:
    """The fingerprint of a file of weights, or of the network of voz."""
    with Path(file or DEFAULT_NETWORK).open("rb") as opened:
        return fingerprint(opened)


def fingerprint(file: IO[bytes]) -> str:
    """The first digits of the SHA-256 of a file's content."""
    digest = sha256()
    while block := file.read(READ_BYTES):
        digest.update(block)
    return digest.hexdigest()[:FINGERPRINT_DIGITS]
