"""The file beside a finished output with the stamps of its recordings.

Its first line is the stamp of the output itself, so that it is never used for another output.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import msgspec

from voz.apps.batch.locations import Location, local_copy, stamps_path
from voz.apps.batch.stamps import Stamp, is_unchanged, stamp_of, with_checksum
from voz.errors import ConfigError
from voz.events import to_json
from voz.files import atomic_write, os_errors_as_config_error, shown_path


class RecordingStamp(msgspec.Struct, frozen=True, omit_defaults=True):
    """The stamp of a recording; None if the file was missing."""

    file: str
    stamp: Stamp | None = None


def write_stamps(output: Location, stamped: Iterable[RecordingStamp]) -> None:
    """Write the stamps of the recordings of a finished output, in the order of its rows.

    Nothing is written for an output that is no regular file, as a pipe.

    Raises:
        ConfigError: it cannot be written.
    """
    seen = stamp_of(str(output))
    if seen is None:
        return
    with local_copy(output) as written:
        stamp = with_checksum(seen, written)
    path = stamps_path(output)
    with os_errors_as_config_error(path), atomic_write(path) as file:
        file.write(to_json(stamp) + "\n")
        file.writelines(to_json(each) + "\n" for each in stamped)


@contextmanager
def read_stamps(output: Location) -> Iterator[Iterator[RecordingStamp] | None]:
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


def _is_of(output: Location, line: bytes) -> bool:
    try:
        return is_unchanged(str(output), msgspec.json.decode(line, type=Stamp))
    except msgspec.MsgspecError:
        return False
