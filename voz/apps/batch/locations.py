"""Where an output is: a file, or an address that fsspec reads and writes whole.

The journal of an address is a file in the working folder, since objects cannot be appended to.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from typing import Any

from voz.apps.batch.file_names import file_name_for
from voz.apps.batch.remote import is_remote, local_recording, reason_of, remote_info
from voz.errors import AudioError, ConfigError
from voz.extras import require
from voz.files import check_new, check_writable, file_exists_error

JOURNAL_ENDING = ".journal"
STAMPS_ENDING = ".recordings"


def journal_path(output: str) -> Path:
    """The journal of an output: beside a file; for an address in the working folder."""
    return _path_for(output, JOURNAL_ENDING)


def stamps_path(output: str) -> Path:
    """The file with the stamps of the recordings of an output; beside its journal."""
    return _path_for(output, STAMPS_ENDING)


def _path_for(output: str, ending: str) -> Path:
    return Path(f"{file_name_for(output) if is_remote(output) else Path(output)}{ending}")


def check_output(output: str, overwrite: bool, advice: str = "") -> None:
    """Refuse, before the work, an output that cannot be written or exists already.

    `advice` is as for `voz.files.check_new`.

    Raises:
        ConfigError: it exists, its folder does not, or nothing here knows such addresses.
    """
    if not is_remote(output):
        check_writable(Path(output))
        check_new(Path(output), overwrite, advice)
        return
    _file_system(output)
    if not overwrite and exists(output):
        raise file_exists_error(output, advice)


def exists(output: str) -> bool:
    """Whether there is an output already; raises ConfigError if that cannot be found out."""
    if not is_remote(output):
        return Path(output).exists()
    system, path = _file_system(output)
    try:
        return bool(system.exists(path))
    except Exception as error:  # each file system fails in its own way
        raise ConfigError(f"{output}: cannot be checked ({reason_of(error)})") from error


def object_state(output: str) -> str:
    """Return a text that changes with an object, so that a write by another run is noticed.

    It is empty if the store does not say, and for a file, whose journal is locked.
    """
    return str(remote_info(output) or "") if is_remote(output) else ""


@contextmanager
def local_copy(output: str) -> Iterator[Path]:
    """Have an output as a local file, in a `with` block; raises ConfigError if it is missing."""
    with ExitStack() as stack:
        try:
            found = stack.enter_context(local_recording(output))
        except AudioError as error:
            raise ConfigError(str(error)) from error
        yield found.path


@contextmanager
def output_file(output: str) -> Iterator[Path]:
    """Yield a file to write, in a `with` block; for an address it is uploaded at the end.

    Raises:
        ConfigError: the object cannot be written.
    """
    if not is_remote(output):
        yield Path(output)
        return
    system, there = _file_system(output)
    with TemporaryDirectory(prefix="voz-") as folder:
        path = Path(folder, "output").with_suffix(PurePath(output).suffix)
        yield path
        is_web = output.startswith(("http://", "https://"))
        try:
            system.put_file(str(path), there, **({"method": "put"} if is_web else {}))
        except Exception as error:
            raise ConfigError(f"{output}: cannot be written ({reason_of(error)})") from error


def _file_system(address: str) -> tuple[Any, str]:
    """The file system of an address, and its path there."""
    require("remote", "fsspec")
    from fsspec.core import url_to_fs

    try:
        system, path = url_to_fs(address)
    except Exception as error:
        raise ConfigError(f"{address}: cannot be opened ({reason_of(error)})") from error
    return system, str(path)
