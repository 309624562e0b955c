"""Stamps: size, time and checksum of a recording when it was decoded, to find changed ones.

The checksum is compared only if size or time differ. Beside a finished output is a file with those
of its recordings; its first line is that of the output itself: it is never used for another one.
"""

from __future__ import annotations

import stat
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import BinaryIO

import msgspec
from msgspec.structs import replace

from voz.apps.batch.locations import (
    is_remote,
    local_copy,
    local_recording,
    remote_info,
    stamps_path,
)
from voz.errors import ConfigError, VozError
from voz.events import to_json
from voz.files import atomic_write, os_errors_as_config_error, sha256, shown_path

CHECKSUM_CHUNK_BYTES = 1 << 20

CHECK_THREADS = 16
"""Threads, since they mostly wait for disks and servers."""

RECORDINGS_PER_THREAD = 64
"""Recordings for a thread at a time: checking one takes less time than handing it over."""

UNINFORMATIVE_FIELDS = ("name", "size", "type", "url", "mimetype", "partial")
"""What a store says of an object that stays the same when it changes."""


class Stamp(msgspec.Struct, frozen=True, omit_defaults=True):
    """What a file or an object was like."""

    size: int | None  # bytes; None if a server does not say it
    version: str  # time of the last change of a file, ns; digest of what a store says of an object
    checksum: str = ""  # of the bytes; empty if they were not read


class RecordingStamp(msgspec.Struct, frozen=True, omit_defaults=True):
    """The stamp of a recording; None if the file was missing."""

    file: str
    stamp: Stamp | None = None


@dataclass(frozen=True)
class StampCheck:
    """A recording that was looked at again."""

    number: int  # index of the recording
    now: Stamp
    changed: bool  # whether its bytes are others


def stamp_of(name: str, base: str = "") -> Stamp | None:
    """Make the stamp of a recording without reading it, and so without a checksum.

    A path is relative to `base`. None if it is missing, or no regular file.
    """
    if is_remote(name):
        return _stamp_of_object(name)
    try:
        status = Path(base, name).stat()
    except (OSError, ValueError):
        return None
    if not stat.S_ISREG(status.st_mode):  # a pipe can be read only once
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
    """Yield the recordings that changed, and those with the same bytes but another time.

    `known` has index and stamp of some; None for what was missing. One that is missing now has not
    changed.
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


def _now(name: str, known: Stamp | None) -> Stamp | None:
    """The stamp now; the file is read only if nothing else says whether it changed."""
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


def write_stamps(output: str, stamped: Iterable[RecordingStamp]) -> None:
    """Write the stamps of a finished output in the order of its rows; raises ConfigError.

    Nothing is written for an output that is no regular file, as a pipe.
    """
    seen = stamp_of(output)
    if seen is None:
        return
    with local_copy(output) as written:
        stamp = with_checksum(seen, written)
    path = stamps_path(output)
    with os_errors_as_config_error(path), atomic_write(path) as file:
        file.write(to_json(stamp) + "\n")
        file.writelines(to_json(each) + "\n" for each in stamped)


@contextmanager
def read_stamps(output: str) -> Iterator[Iterator[RecordingStamp] | None]:
    """Read the stamps of the recordings of an output, in a `with` block.

    Yields:
        The stamps in the order of its rows; None if there are none for this output.
    """
    path = stamps_path(output)
    try:
        file = path.open("rb")
    except OSError:
        yield None
        return
    with file:
        yield _stamped(file, path) if _is_of(output, file.readline()) else None


def _stamped(file: BinaryIO, path: Path) -> Iterator[RecordingStamp]:
    try:
        for line in file:
            yield msgspec.json.decode(line, type=RecordingStamp)
    except msgspec.MsgspecError as error:
        raise ConfigError(f"{shown_path(path)}: is damaged ({error}); remove it") from error


def _is_of(output: str, line: bytes) -> bool:
    """Whether an output has the bytes that the stamp in a line was made of."""
    try:
        known = msgspec.json.decode(line, type=Stamp)
    except msgspec.MsgspecError:
        return False
    now = _now(output, known)
    return now is not None and _same_bytes(known, now)
