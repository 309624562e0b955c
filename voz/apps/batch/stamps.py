"""What a recording was like when it was decoded, so that a later run finds those that changed.

A recording whose size and time are still the same is taken as it was; only otherwise its bytes are
read and their checksum compared.
"""

from __future__ import annotations

import stat
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from hashlib import sha256
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import msgspec
from msgspec.structs import replace

from voz.apps.batch.remote import is_remote, local_recording, remote_info
from voz.errors import VozError

CHECKSUM_CHUNK_BYTES = 1 << 20

CHECK_THREADS = 16
"""They wait for disks and servers; one alone would wait for each recording in turn."""

RECORDINGS_PER_THREAD = 64
"""Recordings for each thread at a time: to look at a file takes less than to hand it over."""

UNINFORMATIVE_FIELDS = ("name", "size", "type", "url", "mimetype", "partial")
"""What a store says of an object that a changed one may have, too."""


class Stamp(msgspec.Struct, frozen=True, omit_defaults=True):
    """What a file or an object was like.

    Attributes:
        size: bytes; None if a server does not say it.
        version: of a file the time of its last change, ns; of an object the digest of what its
            store says of it, as an ETag; empty if that is nothing.
        checksum: of the bytes; empty if they were not read.
    """

    size: int | None
    version: str
    checksum: str = ""


class StampCheck(NamedTuple):
    """A recording that was looked at again.

    Attributes:
        number: which one.
        now: what it is like.
        changed: whether its bytes are others.
    """

    number: int
    now: Stamp
    changed: bool


def stamp_of(name: str, base: str = "") -> Stamp | None:
    """Look at a recording without reading it.

    Args:
        name: a path, or an address that fsspec opens.
        base: the folder that a path is from; empty for the one that this process is in.

    Returns:
        Its stamp without a checksum; None if it is not there, or no regular file.
    """
    if is_remote(name):
        return _stamp_of_object(name)
    try:
        status = Path(base, name).stat()
    except (OSError, ValueError):
        return None
    if not stat.S_ISREG(status.st_mode):  # what is read from a pipe is gone
        return None
    return Stamp(status.st_size, str(status.st_mtime_ns))


def with_checksum(stamp: Stamp, path: Path) -> Stamp:
    """Add the checksum of a file to its stamp, which was made before; none if it is unreadable."""
    whole = sha256()
    try:
        with path.open("rb") as file:
            while piece := file.read(CHECKSUM_CHUNK_BYTES):
                whole.update(piece)
    except OSError:
        return stamp
    return replace(stamp, checksum=whole.hexdigest()[:16])


def check_stamps(
    names: Sequence[str], known: Iterable[tuple[int, Stamp | None]]
) -> Iterator[StampCheck]:
    """Look which recordings are no longer as they were.

    Args:
        names: paths and addresses of all recordings.
        known: the numbers of some, and what they were like; None for what was not there.

    Yields:
        Those that changed, and those that have the same bytes but another time. What is not there
        now has not changed.
    """

    def look(some: list[tuple[int, Stamp | None]]) -> list[StampCheck]:
        looked = [(number, before, _now(names[number], before)) for number, before in some]
        return [
            StampCheck(number, now, before is None or not _same_bytes(before, now))
            for number, before, now in looked
            if now is not None and now != before
        ]

    known = iter(known)
    with ThreadPoolExecutor(CHECK_THREADS) as pool:
        while some := list(islice(known, CHECK_THREADS * RECORDINGS_PER_THREAD)):
            parts = [
                some[at : at + RECORDINGS_PER_THREAD]
                for at in range(0, len(some), RECORDINGS_PER_THREAD)
            ]
            for looked in pool.map(look, parts):
                yield from looked


def is_unchanged(name: str, known: Stamp) -> bool:
    """Whether a file or an object has the same bytes as when it had a stamp."""
    now = _now(name, known)
    return now is not None and _same_bytes(known, now)


def _now(name: str, known: Stamp | None) -> Stamp | None:
    """What a recording is like now; it is read only if nothing else says whether it changed."""
    now = stamp_of(name)
    if now is None or known is None or now.size != known.size:
        return now
    if now.version and now.version == known.version:
        return known
    try:
        with local_recording(name) as found:
            return with_checksum(now, found.path)
    except VozError:
        return None


def _same_bytes(before: Stamp, now: Stamp) -> bool:
    return (before.size, before.checksum) == (now.size, now.checksum)


def _stamp_of_object(name: str) -> Stamp | None:
    info = remote_info(name)
    if info is None:
        return None
    said = sorted(
        (key, str(value)) for key, value in info.items() if key not in UNINFORMATIVE_FIELDS
    )
    version = sha256(repr(said).encode()).hexdigest()[:16] if said else ""
    return Stamp(info.get("size"), version)
