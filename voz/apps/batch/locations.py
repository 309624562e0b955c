"""Where an output is: a file, or an address that fsspec reads and writes whole.

The journal of an address is a file in the working folder, since objects cannot be appended to.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

from voz.apps.batch.remote import (
    file_name_for,
    is_remote,
    local_recording,
    require_fsspec,
    shown_name,
)
from voz.errors import AudioError, ConfigError
from voz.files import check_new, check_writable, file_exists_error

JOURNAL_ENDING = ".journal"
STAMPS_ENDING = ".recordings"

Location: TypeAlias = Path | str
"""A file, or the address of an object, as `s3://bucket/heard.jsonl`."""


def parse_location(name: str) -> Location:
    """Return the path or the address that the name of an output means."""
    return name if is_remote(name) else Path(name)


def shown_location(place: Location) -> str:
    """An output as messages show it."""
    return shown_name(str(place))


def journal_path(output: Location) -> Path:
    """The journal of an output: beside a file; for an address in the working folder."""
    return _path_for(output, JOURNAL_ENDING)


def stamps_path(output: Location) -> Path:
    """The file with the stamps of the recordings of an output; beside its journal."""
    return _path_for(output, STAMPS_ENDING)


def _path_for(output: Location, ending: str) -> Path:
    if isinstance(output, Path):
        return output.with_name(output.name + ending)
    return Path(file_name_for(output) + ending)


def check_output(output: Location, overwrite: bool, advice: str = "") -> None:
    """Refuse, before the work, an output that cannot be written or exists already.

    `advice` is as for `voz.files.check_new`.

    Raises:
        ConfigError: it exists, its folder does not, or nothing here knows such addresses.
    """
    if isinstance(output, Path):
        check_writable(output)
        check_new(output, overwrite, advice)
        return
    _file_system(output)
    if not overwrite and exists(output):
        raise file_exists_error(output, advice)


def exists(output: Location) -> bool:
    """Whether there is an output already; raises ConfigError if that cannot be found out."""
    if isinstance(output, Path):
        return output.exists()
    system, path = _file_system(output)
    try:
        return bool(system.exists(path))
    except Exception as error:  # each file system fails in its own way
        raise ConfigError(f"{output}: cannot be checked ({_reason(error)})") from error


def object_state(output: Location) -> str:
    """Describe an object, so that a write by another run is noticed.

    Returns:
        Text that changes with the object; empty if there is none, if the store does not say, and
        for a file, whose journal is locked.
    """
    if isinstance(output, Path):
        return ""
    system, path = _file_system(output)
    system.invalidate_cache()
    try:
        return str(system.info(path))
    except Exception:  # each file system fails in its own way
        return ""


@contextmanager
def local_copy(output: Location) -> Iterator[Path]:
    """Have an output as a local file, in a `with` block; raises ConfigError if it is missing."""
    if isinstance(output, Path):
        yield output
        return
    with ExitStack() as stack:
        try:
            found = stack.enter_context(local_recording(output))
        except AudioError as error:
            raise ConfigError(str(error)) from error
        yield found.path


@contextmanager
def output_file(output: Location) -> Iterator[Path]:
    """Yield a file to write, in a `with` block; for an address it is uploaded at the end.

    Raises:
        ConfigError: the object cannot be written.
    """
    if isinstance(output, Path):
        yield output
        return
    system, there = _file_system(output)
    with TemporaryDirectory(prefix="voz-") as folder:
        path = Path(folder, "output").with_suffix(PurePath(output).suffix)
        yield path
        is_web = output.startswith(("http://", "https://"))
        how = {"method": "put"} if is_web else {}
        try:
            system.put_file(str(path), there, **how)
        except Exception as error:
            raise ConfigError(f"{output}: cannot be written ({_reason(error)})") from error


def _file_system(address: str) -> tuple[Any, str]:
    """The file system of an address, and its path there."""
    require_fsspec()
    from fsspec.core import url_to_fs

    try:
        system, path = url_to_fs(address)
    except Exception as error:
        raise ConfigError(f"{address}: cannot be opened ({_reason(error)})") from error
    return system, str(path)


def _reason(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
