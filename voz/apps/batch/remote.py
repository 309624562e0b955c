"""Recordings at addresses that fsspec opens, fetched by the worker that decodes them."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from voz.errors import AudioError
from voz.extras import require
from voz.files import shown_path

MOST_FETCHED_BYTES = 4_000_000_000
"""A stream may be endless; a day of 16 bits at 16 kHz has 2.8 GB."""

FETCH_CHUNK_BYTES = 1 << 20


@dataclass(frozen=True)
class LocalRecording:
    """A recording on this machine: its path, and its name in results."""

    path: Path
    name: str


def is_remote(name: str) -> bool:
    """Whether a name is an address, as `s3://bucket/file.wav`, and not a path."""
    return "://" in name


def shown_name(name: str) -> str:
    """A path or an address as results have it."""
    return name if is_remote(name) else shown_path(Path(name))


@contextmanager
def local_recording(name: str, base: str = "") -> Iterator[LocalRecording]:
    """Have a recording on this machine, fetched if need be, in a `with` block.

    Args:
        name: a path, or an address that fsspec opens.
        base: the folder that a path is relative to; empty for the working folder.

    Raises:
        AudioError: it cannot be fetched.
        ConfigError: fsspec is not installed, or does not know such addresses.
    """
    if not is_remote(name):
        yield LocalRecording(Path(base, name), shown_name(name))
        return
    with tempfile.NamedTemporaryFile(prefix="voz-", suffix=Path(name).suffix) as file:
        for piece in _pieces(name):
            file.write(piece)
        file.flush()
        yield LocalRecording(Path(file.name), name)


def remote_info(name: str) -> dict[str, Any] | None:
    """What a store says of an object, as its size and ETag; None if nothing."""
    try:
        from fsspec.core import url_to_fs

        system, path = url_to_fs(name)
        system.invalidate_cache()  # its answers are cached
        return dict(system.info(path))
    except Exception:  # each of its file systems fails in its own way
        return None


def _pieces(name: str) -> Iterator[bytes]:
    require("remote", "fsspec")
    import fsspec

    read = 0
    try:
        with fsspec.open(name, "rb") as remote:
            while piece := remote.read(FETCH_CHUNK_BYTES):
                read += len(piece)
                if read > MOST_FETCHED_BYTES:
                    limit = f"{MOST_FETCHED_BYTES / 1e9:g} GB"
                    raise AudioError(f"{name}: is larger than {limit}; cut it")
                yield piece
    except (AudioError, MemoryError):
        raise
    except Exception as error:  # each of its file systems fails in its own way
        raise AudioError(f"{name}: cannot be fetched ({reason_of(error)})") from error


def reason_of(error: Exception) -> str:
    """The message of an error of fsspec in one line."""
    return " ".join(str(error).split()) or type(error).__name__
