"""Where recordings and outputs are: files, or addresses that fsspec opens.

The worker that decodes a recording fetches it. An output at an address is written whole; its
journal is a file in the working folder, since objects cannot be appended to.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from typing import Any

from voz.errors import AudioError, ConfigError
from voz.extras import require
from voz.files import check_new, check_writable, file_exists_error, sha256, shown_path

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
    """A path or an address as results have it; what is no text in it is escaped."""
    if not is_remote(name):
        return shown_path(Path(name))
    return name.encode("utf-8", "backslashreplace").decode()


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
        yield LocalRecording(Path(file.name), shown_name(name))


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


LONGEST_FILE_NAME = 200
"""Bytes; file systems take 255, with endings."""

EVENTS_ENDING = ".jsonl"
"""Of the events of a simulated run."""

FOLDER_SEPARATOR = "+"
"""Stands in names of files for the `/` between folders."""

ESCAPED_CHARACTERS = frozenset(r'%+\:*?"<>|')
"""What file systems refuse or programs take for something else, and what stands for others."""


def file_name_for(name: str) -> str:
    """Make a unique file name of a path or an address: `rooms+kitchen+1.wav`."""
    escaped = "".join(map(_in_file_name, name))
    if escaped.startswith("."):  # else it would be hidden, or lead elsewhere
        escaped = _escaped(".") + escaped[1:]
    encoded = escaped.encode()
    if len(encoded) <= LONGEST_FILE_NAME:
        return escaped
    end = encoded[-LONGEST_FILE_NAME // 2 :].decode(errors="ignore")
    return f"{sha256(encoded).hexdigest()[:16]}-{end}"


def _in_file_name(character: str) -> str:
    if character == "/":
        return FOLDER_SEPARATOR
    if character.isprintable() and character not in ESCAPED_CHARACTERS:
        return character
    return _escaped(character)


def _escaped(text: str) -> str:
    return "".join(f"%{byte:02X}" for byte in text.encode("utf-8", "surrogateescape"))


def check_none_there(folder: Path, names: Iterable[str], ending: str) -> None:
    """Refuse to replace files of an earlier run in a folder; raises ConfigError.

    Each has a recording's name, as results have it, and the ending.
    """
    for name in names:
        check_new(folder / (file_name_for(name) + ending), overwrite=False)


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
