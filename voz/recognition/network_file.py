"""The file of the phoneme network."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import msgspec
import numpy as np
import numpy.typing as npt

from voz.checksum import sha256
from voz.files import atomic_write

Floats = npt.NDArray[np.float32]

DEFAULT_NETWORK = Path(__file__).with_name("phonemes.npz")
"""The network of voz; `training/` makes such files."""

DESCRIPTION = "description"
"""Entry with the `Description` in JSON, as bytes."""

FINGERPRINT_DIGITS = 12

READ_BYTES = 65_536


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
        with path.open("rb") as file, np.load(file, allow_pickle=False) as entries:
            description = msgspec.json.decode(entries[DESCRIPTION].tobytes(), type=Description)
            names = [name for name in entries.files if name != DESCRIPTION]
            # One after the other: all of them in both precisions would take 4 MB more.
            weights = {name: entries[name].astype(np.float32) for name in names}
            file.seek(0)
            identity = fingerprint(file)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise UnknownNetworkError(f"{path}: holds no phoneme network ({error})") from error
    return NetworkFile(weights, description, identity)


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


def fingerprint(file: BinaryIO) -> str:
    """The first digits of the SHA-256 of a file's content."""
    digest = sha256()
    while block := file.read(READ_BYTES):
        digest.update(block)
    return digest.hexdigest()[:FINGERPRINT_DIGITS]
