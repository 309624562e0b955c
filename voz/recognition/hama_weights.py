"""The weights of the network in PyPI's `hama`: found in the package, and read without it."""

from __future__ import annotations

import math
import struct
from importlib.util import find_spec
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]

MAGIC = b"HAMAPK"
HEADER = len(MAGIC) + 2
"""With its version."""

NUMBERS = ("<f4", "<f2")
"""The types of its tensors, by number."""


class UnknownNetworkError(Exception):
    """The package is not there, or brings a network that is none of those known here."""


def find_assets() -> Path:
    """Find the folder of its files; raises UnknownNetworkError if the package is not installed."""
    package = find_spec("hama")
    folders = package.submodule_search_locations if package else None
    for folder in folders or ():
        return Path(folder) / "assets"
    raise UnknownNetworkError("PyPI's `hama` is not installed")


def read_symbols(path: Path) -> list[str]:
    """Read what the network knows, in IPA; raises UnknownNetworkError if the file is another."""

    class Vocabulary(msgspec.Struct):
        decoder: list[str]

    try:
        return msgspec.json.decode(path.read_bytes(), type=Vocabulary).decoder
    except (OSError, msgspec.DecodeError) as error:
        raise UnknownNetworkError(f"{path}: {error}") from error


def read_tensors(path: Path) -> dict[str, Floats]:
    """Read the weights; raises UnknownNetworkError if the file is another.

    After the header and their number, each tensor has the length of its name, its name, its type (0
    for 32-bit numbers, 1 for 16), its number of dimensions, these, and its place and size in what
    comes after all of that, at the end of the file.
    """
    try:
        content = path.read_bytes()
        if not content.startswith(MAGIC):
            raise UnknownNetworkError(f"{path}: is no file of weights")
        (count,) = struct.unpack_from("<I", content, HEADER)
        at, listed = HEADER + 4, []
        for _ in range(count):
            (length,) = struct.unpack_from("<H", content, at)
            name = content[at + 2 : at + 2 + length].decode("ascii")
            kind, rank = struct.unpack_from("<BB", content, at + 2 + length)
            at += 4 + length
            *shape, place, size = struct.unpack_from(f"<{rank}IQQ", content, at)
            at += 4 * rank + 16
            listed.append((name, NUMBERS[kind], tuple(shape), place, size))
        begin = len(content) - max(place + size for *_, place, size in listed)
        return {
            name: np.frombuffer(content, numbers, math.prod(shape), begin + place)
            .reshape(shape)
            .astype(np.float32)
            for name, numbers, shape, place, _ in listed
        }
    except (OSError, ValueError, LookupError, struct.error) as error:
        raise UnknownNetworkError(f"{path}: {error}") from error
