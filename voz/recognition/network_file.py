"""The file of the phoneme network."""

from __future__ import annotations

import hashlib
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from voz.files import atomic_write

Floats = npt.NDArray[np.float32]

DEFAULT_NETWORK = Path(__file__).with_name("phonemes.npz")
"""The network of voz; `training/` makes such files."""

DESCRIPTION = "description"
"""Entry with the `Description` in JSON, as bytes."""

FINGERPRINT_DIGITS = 12


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
        content = path.read_bytes()
        with np.load(BytesIO(content), allow_pickle=False) as entries:
            weights = {name: entries[name] for name in entries.files}
        description = msgspec.json.decode(weights.pop(DESCRIPTION).tobytes(), type=Description)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise UnknownNetworkError(f"{path}: holds no phoneme network ({error})") from error
    floats = {name: tensor.astype(np.float32) for name, tensor in weights.items()}
    return NetworkFile(floats, description, fingerprint(content))


def write_network(path: Path, weights: dict[str, Floats], description: Description) -> None:
    """Write a file of weights, in half precision."""
    entries: dict[str, Any] = {name: tensor.astype(np.float16) for name, tensor in weights.items()}
    entries[DESCRIPTION] = np.frombuffer(msgspec.json.encode(description), np.uint8)
    with atomic_write(path, "wb") as file:  # who is killed meanwhile keeps the old one
        np.savez(file, **entries)


def fingerprint_of(file: str | None = None) -> str:
    """The fingerprint of a file of weights, or of the network of voz."""
    return fingerprint(Path(file or DEFAULT_NETWORK).read_bytes())


def fingerprint(content: bytes) -> str:
    """The first digits of the SHA-256 of a file's content."""
    return hashlib.sha256(content).hexdigest()[:FINGERPRINT_DIGITS]
