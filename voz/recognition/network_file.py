"""The file of the phoneme network: its weights, its symbols, and where it comes from."""

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
"""The network that comes with voz; `training/` makes such files."""

DESCRIPTION = "description"
"""The entry that describes the others: a `Description` in JSON, as bytes."""

FINGERPRINT_DIGITS = 12


class UnknownNetworkError(Exception):
    """There is no such file, or it holds no network that voz computes."""


class Description(msgspec.Struct, forbid_unknown_fields=True):
    """What a file of weights says about itself.

    Attributes:
        symbols: what the network's outputs stand for, in IPA; the last two are `<wb>`, between
            two words, and `<blank>`, no new symbol.
        origin: what it was made from, by whom, on which data, with which seed.
        licence: of the weights, with the notice that has to go with them.
    """

    symbols: list[str]
    origin: str
    licence: str


class NetworkFile(NamedTuple):
    """The content of a file of weights.

    Attributes:
        weights: the tensors by name, as `training/network.py` lists them.
        description: what the file says about itself.
        fingerprint: tells the file from every other one.
    """

    weights: dict[str, Floats]
    description: Description
    fingerprint: str


def read_network(path: Path) -> NetworkFile:
    """Read a file of weights.

    Args:
        path: of a file in numpy's `.npz` format, with an entry for each tensor.

    Raises:
        UnknownNetworkError: it cannot be read, or is another kind of file.
    """
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
    """Write a file of weights, in half precision; it reads back as `read_network` gives it."""
    entries: dict[str, Any] = {name: tensor.astype(np.float16) for name, tensor in weights.items()}
    entries[DESCRIPTION] = np.frombuffer(msgspec.json.encode(description), np.uint8)
    with atomic_write(path, "wb") as file:  # who is killed meanwhile keeps the old one
        np.savez(file, **entries)


def fingerprint_of(file: str | None = None) -> str:
    """The fingerprint of a file of weights; without one, of those that come with voz."""
    return fingerprint(Path(file or DEFAULT_NETWORK).read_bytes())


def fingerprint(content: bytes) -> str:
    """The first digits of the SHA-256 of a file's content."""
    return hashlib.sha256(content).hexdigest()[:FINGERPRINT_DIGITS]
