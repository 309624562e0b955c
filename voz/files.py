"""Atomic writes, bounded reads of the files that users name (`/dev/zero` never ends), digests."""

from __future__ import annotations

import errno
import os
import stat
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, TypeVar

import msgspec

from voz.errors import ConfigError, VozError

# SHA-256 as `hashlib` has it, without the 3.5 MB of OpenSSL that importing `hashlib` loads.
if TYPE_CHECKING:
    from hashlib import sha256 as sha256
else:
    try:
        from _sha2 import sha256 as sha256  # Python 3.12 and later
    except ImportError:
        try:
            from _sha256 import sha256 as sha256
        except ImportError:  # a Python that was built without algorithms of its own
            from hashlib import sha256 as sha256

Kind = TypeVar("Kind")

MAX_FILE_BYTES = 100_000_000
"""Default limit of a read, bytes; a comparison of 300,000 clips is smaller."""

READ_BYTES = 1_000_000
"""Of a file that are read at once, bytes."""

MAX_SETTINGS_BYTES = 1_000_000
"""Limit of settings and of what voz learns, bytes."""

OPEN_FILES_FOLDER = Path("/proc/self/fd")
"""Names of the files that this process has open."""

OPEN_PIPES = ("/dev/fd/", "/dev/stdin", "/proc/")
"""How the names of pipes begin that are open already, as those of `<(...)`."""


def shown_path(path: Path) -> str:
    """A path as text for messages and JSON; bytes that are not UTF-8 are escaped."""
    return os.fsencode(path).decode(errors="backslashreplace")


def data_folder(kind: str) -> Path:
    """Return `$XDG_DATA_HOME/voz/KIND` or `~/.local/share/voz/KIND`; it may not exist yet.

    Raises:
        ConfigError: there is no home folder.
    """
    home = os.environ.get("XDG_DATA_HOME", "")
    try:
        # The XDG standard: a relative path is ignored.
        data = Path(home) if Path(home).is_absolute() else Path.home() / ".local" / "share"
    except RuntimeError as error:
        raise ConfigError(f"there is no home folder for {kind}; set XDG_DATA_HOME") from error
    return data / "voz" / kind


def read_bytes(
    path: Path, error_type: type[VozError], advice: str, limit: int = MAX_FILE_BYTES
) -> bytes:
    """Read a whole file that a user named.

    Args:
        path: a pipe, as of `<(...)`, is read to its end; one with a name of its own is refused.
        error_type: what is raised if it cannot be read.
        advice: what the user can do then.
        limit: the largest size, bytes.

    Raises:
        VozError: the file cannot be read or is too large; of `error_type`.
    """
    try:
        with open_to_read(path) as file:
            data = _read_up_to(file, limit + 1)
    except OSError as error:
        raise error_type(f"{shown_path(path)}: cannot be read ({error.strerror})", advice) from None
    except ValueError:  # a file name cannot contain a zero byte
        raise error_type(f"{str(path)!a}: cannot be the name of a file", advice) from None
    if len(data) > limit:
        raise error_type(f"{shown_path(path)}: is larger than {limit:,} bytes", advice)
    return data


def is_file(path: Path) -> bool:
    """Whether there is a regular file, whatever the name."""
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that is too long, or a folder that nobody may read
        return False


def _read_up_to(file: IO[bytes], most: int) -> bytes:
    """Read to the end, or `most` bytes; Python makes room for as many as it is asked for."""
    data = bytearray()
    while len(data) < most and (part := file.read(min(READ_BYTES, most - len(data)))):
        data += part
    return bytes(data)


def open_to_read(path: Path) -> IO[bytes]:
    """Open a file that a user named; nobody may ever write to a named pipe, so that is refused.

    Raises:
        OSError: it cannot be opened, or is a named pipe.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        is_pipe = stat.S_ISFIFO(os.fstat(descriptor).st_mode)
        if is_pipe and not str(path.absolute()).startswith(OPEN_PIPES):
            raise OSError(errno.ESPIPE, "it is a pipe", str(path))
        os.set_blocking(descriptor, True)
        return os.fdopen(descriptor, "rb")
    except OSError:
        os.close(descriptor)
        raise


def read_text(
    path: Path, error_type: type[VozError], advice: str, limit: int = MAX_FILE_BYTES
) -> str:
    """As `read_bytes`, for UTF-8 text with or without a byte order mark, and any line ends."""
    try:
        text = read_bytes(path, error_type, advice, limit).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise error_type(f"{shown_path(path)}: is not UTF-8 text", advice) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_json(
    path: Path,
    kind: type[Kind],
    error_type: type[VozError],
    advice: str,
    limit: int = MAX_FILE_BYTES,
) -> Kind:
    """As `read_bytes`, for JSON of a type."""
    data = read_bytes(path, error_type, advice, limit)
    try:
        return msgspec.json.decode(data, type=kind)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise error_type(f"{shown_path(path)}: cannot be used ({error})", advice) from None


@contextmanager
def atomic_write(path: Path, mode: str = "w") -> Iterator[IO[Any]]:
    """Replace a file when the block ends without an exception; else the old one stays.

    Args:
        path: if it is a link, its target is replaced; a pipe or device is written directly.
        mode: `w` for text, in UTF-8, or `wb` for bytes.

    Yields:
        The new file. It has no name until it is complete, where the file system can do that, so
        that a killed program leaves nothing behind.

    Raises:
        OSError: it cannot be written.
    """
    how: dict[str, Any] = {} if "b" in mode else {"encoding": "utf-8", "errors": "replace"}
    if path.exists() and not path.is_file():
        with path.open(mode, **how) as file:
            yield file
        return
    target = Path(os.path.realpath(path))
    part = target.with_name(f".voz-{uuid.uuid4().hex}.part")
    try:
        with os.fdopen(_open_part(part), mode, **how) as file:
            _copy_permissions(target, file.fileno())
            yield file
            file.flush()
            os.fsync(file.fileno())  # robots lose their power
            _link_name(file.fileno(), part)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def append_line(path: Path, line: str) -> None:
    """Append a line to a text file, all of it or nothing, after a newline if one is missing.

    Raises:
        OSError: it cannot be written.
    """
    with path.open("a+b", buffering=0) as file:
        size = os.fstat(file.fileno()).st_size
        file.seek(max(0, size - 1))
        begin = b"" if file.read(1) in (b"", b"\n") else b"\n"
        data = begin + line.encode("utf-8", "replace") + b"\n"
        try:
            if file.write(data) < len(data):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        except BaseException:
            file.truncate(size)
            raise


@contextmanager
def os_errors_as_config_error(path: str | Path) -> Iterator[None]:
    """Turn an OSError of a block that writes `path` into a ConfigError of one line."""
    try:
        yield
    except BrokenPipeError:  # the reader of standard output has closed it
        raise
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written ({error.strerror or error})") from error


def check_writable(path: Path) -> None:
    """Raise ConfigError, before the work, if its result cannot be written."""
    with os_errors_as_config_error(path):
        is_kept = path.exists() and not path.is_file()  # a pipe, or a device: see `atomic_write`
        changed = [] if is_kept else [Path(os.path.realpath(path)).parent]
        changed += [path] if path.exists() else []
        usable = all(os.access(each, os.W_OK, effective_ids=True) for each in changed)
    if path.is_dir() or not usable:
        raise ConfigError(f"{path}: cannot be written there; name a file in a folder of yours")


def check_new(path: Path, overwrite: bool, advice: str = "") -> None:
    """Raise ConfigError, before the work, if its result would replace a file.

    Args:
        path: an empty file, a pipe and a device may be replaced.
        overwrite: whether the user gave `--overwrite`.
        advice: what else to do, as a part of a sentence that ends in a comma.
    """
    try:
        status = path.stat()
    except OSError:  # it is not there
        return
    if not overwrite and stat.S_ISREG(status.st_mode) and status.st_size:
        raise file_exists_error(str(path), advice)


def file_exists_error(name: str, advice: str = "") -> ConfigError:
    """The error of `check_new`."""
    return ConfigError(
        f"{name}: is there already; {advice}replace it by --overwrite, or name another file"
    )


def check_not_read(written: Iterable[str | Path], read: Iterable[str | Path]) -> None:
    """Check that no file is both read and written, or written twice, whatever its name.

    Args:
        written: files that will be written; `-` is standard output.
        read: files and folders that are read meanwhile; `-` is standard input.

    Raises:
        ConfigError: two of them are the same file.
    """
    read = _files_in("/dev/stdin" if name == "-" else name for name in read)
    known: dict[object, str | Path] = {_file_id(name): name for name in read}
    for name in written:
        file_id = _file_id("/dev/stdout" if name == "-" else name)
        if file_id is not None and file_id in known:
            other = "" if str(known[file_id]) == str(name) else f", as {known[file_id]}"
            raise ConfigError(f"{name}: is read or written already{other}; name another file")
        known[file_id] = name


def _files_in(names: Iterable[str | Path]) -> Iterator[Path]:
    for path in map(Path, names):
        yield from path.iterdir() if path.is_dir() else [path]


def _file_id(name: str | Path) -> object:
    """Identify a file by its inode; None for a pipe or device."""
    try:
        status = Path(name).stat()
    except OSError:  # it is not there yet
        return os.path.realpath(name)
    return (status.st_dev, status.st_ino) if stat.S_ISREG(status.st_mode) else None


def _open_part(part: Path) -> int:
    """Open a new file for writing, without a name where it can be given one later."""
    if hasattr(os, "O_TMPFILE") and OPEN_FILES_FOLDER.exists():
        with suppress(OSError):  # NFS and FAT cannot; the open below reports other errors
            return os.open(part.parent, os.O_TMPFILE | os.O_WRONLY, 0o666)
    return os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)


def _link_name(file: int, part: Path) -> None:
    """Give an open file its name, if it has none yet, as open(2) describes."""
    if os.fstat(file).st_nlink == 0:
        # Python follows links only if a `dir_fd` is given; an absolute path ignores it.
        os.link(OPEN_FILES_FOLDER / str(file), part, src_dir_fd=file)


def _copy_permissions(target: Path, part: int) -> None:
    if target.exists():
        if not os.access(target, os.W_OK, effective_ids=True):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(target))
        os.fchmod(part, stat.S_IMODE(target.stat().st_mode))
