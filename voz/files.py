"""Writes files so that nothing is lost, and reads what users name, however it is broken.

Writing is whole or not at all, a line or none of it. Reading is bounded: `/dev/zero` never ends.
"""

from __future__ import annotations

import errno
import os
import stat
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any, TypeVar

import msgspec

from voz.errors import ConfigError, VozError

Kind = TypeVar("Kind")

MOST_BYTES = 100_000_000
"""No list, table or model of voz's is larger; a comparison of 300,000 clips is not."""

FEW_BYTES = 1_000_000
"""No settings of voz's, nor what it learns, are larger."""

FILES_OPEN = Path("/proc/self/fd")
"""Where the files that this process has open have names."""


def shown_path(path: Path) -> str:
    """A path as text that JSON can hold too, with escapes for what is no UTF-8 in it."""
    return os.fsencode(path).decode(errors="backslashreplace")


def data_folder(kind: str) -> Path:
    """Name a folder for what users keep, which need not be there.

    Args:
        kind: what it is for, as `profiles`.

    Returns:
        A path under `$XDG_DATA_HOME/voz`, or `~/.local/share/voz`.

    Raises:
        ConfigError: there is no home folder.
    """
    home = os.environ.get("XDG_DATA_HOME", "")
    try:
        # The standard says that a path which is not absolute is to be ignored.
        data = Path(home) if Path(home).is_absolute() else Path.home() / ".local" / "share"
    except RuntimeError as error:
        raise ConfigError(f"there is no home folder for {kind}; set XDG_DATA_HOME") from error
    return data / "voz" / kind


def read_bytes(path: Path, wrong: type[VozError], advice: str, limit: int = MOST_BYTES) -> bytes:
    """Read a file that a user named, whole.

    Args:
        path: of the file; a pipe, as of `<(...)`, is read to its end.
        wrong: what is raised if it cannot be read.
        advice: what the user can do then.
        limit: how large it may be, bytes.

    Raises:
        VozError: the file cannot be read or is too large; it is a `wrong`.
    """
    try:
        with path.open("rb") as file:
            data = file.read(limit + 1)
    except OSError as error:
        raise wrong(f"{shown_path(path)}: cannot be read ({error.strerror}); {advice}") from None
    except ValueError:  # no name of a file has a zero in it
        raise wrong(f"{str(path)!a}: cannot be the name of a file; {advice}") from None
    if len(data) > limit:
        raise wrong(f"{shown_path(path)}: is larger than {limit:,} bytes; {advice}")
    return data


def read_text(path: Path, wrong: type[VozError], advice: str, limit: int = MOST_BYTES) -> str:
    """Read a text that a user named, in UTF-8 with or without a byte order mark, and any line ends.

    Arguments and errors are those of `read_bytes`.
    """
    try:
        text = read_bytes(path, wrong, advice, limit).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise wrong(f"{shown_path(path)}: is not UTF-8 text; {advice}") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_json(
    path: Path, kind: type[Kind], wrong: type[VozError], advice: str, limit: int = MOST_BYTES
) -> Kind:
    """Read what voz keeps as JSON, of some kind; the rest is as with `read_bytes`."""
    data = read_bytes(path, wrong, advice, limit)
    try:
        return msgspec.json.decode(data, type=kind)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise wrong(f"{shown_path(path)}: cannot be used ({error}); {advice}") from None


@contextmanager
def replaced(path: Path, mode: str = "w") -> Iterator[IO[Any]]:
    """Write a file anew; until it is complete, and if it never is, the old one stays.

    Args:
        path: of the file; if it is a link, what it points to is replaced.
        mode: `w` for text, in UTF-8, or `wb` for bytes.

    Yields:
        A file that takes the place of `path` when the block ends without an exception. Until then
        it has no name, where the file system can do that: of a killed program nothing is left.
        What is no regular file, as a pipe or `/dev/null`, is written directly.

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
        with os.fdopen(_opened(part), mode, **how) as file:
            _like_the_old(target, file.fileno())
            yield file
            file.flush()
            os.fsync(file.fileno())  # robots lose their power
            _give_name(file.fileno(), part)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def append_line(path: Path, line: str) -> None:
    """Add a line to a text file: all of it or nothing, also if what is there lacks a line's end.

    Args:
        path: of the file; it is made if need be.
        line: what to add, without its end.

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
def told(path: str | Path) -> Iterator[None]:
    """Say in one line, in a `with` block that writes a file, why it cannot be written.

    Raises:
        ConfigError: in place of the OSError that was raised in the block.
    """
    try:
        yield
    except BrokenPipeError:  # whoever reads standard output has seen enough
        raise
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written ({error.strerror or error})") from error


def check_writable(path: Path) -> None:
    """Refuse, before the work whose result it is to hold, a file that cannot be written.

    Raises:
        ConfigError: it is protected or a folder, or there is no folder that it could be in.
    """
    with told(path):
        is_kept = path.exists() and not path.is_file()  # a pipe, or a device: see `replaced`
        changed = [] if is_kept else [Path(os.path.realpath(path)).parent]
        changed += [path] if path.exists() else []
        usable = all(os.access(each, os.W_OK, effective_ids=True) for each in changed)
    if path.is_dir() or not usable:
        raise ConfigError(f"{path}: cannot be written there; name a file in a folder of yours")


def check_new(path: Path, overwrite: bool, advice: str = "") -> None:
    """Refuse, before the work, to replace a result that is there.

    Args:
        path: of the file; an empty one, a pipe and a device have nothing to lose.
        overwrite: whether the user asked for it by `--overwrite`.
        advice: what else can be done, as a part of a sentence that ends in a comma.

    Raises:
        ConfigError: it is there.
    """
    try:
        status = path.stat()
    except OSError:  # it is not there
        return
    if not overwrite and stat.S_ISREG(status.st_mode) and status.st_size:
        raise already_there(str(path), advice)


def already_there(name: str, advice: str = "") -> ConfigError:
    """The error for a result that would be replaced; see `check_new`."""
    return ConfigError(
        f"{name}: is there already; {advice}replace it by --overwrite, or name another file"
    )


def check_not_read(written: Iterable[str | Path], read: Iterable[str | Path]) -> None:
    """Refuse to write a file that is read, or two results into one, by whatever name.

    Args:
        written: files that will be written; `-` is standard output.
        read: files that are read meanwhile, and folders whose files are; `-` is standard input.

    Raises:
        ConfigError: two of them are the same file.
    """
    read = _files("/dev/stdin" if name == "-" else name for name in read)
    known: dict[object, str | Path] = {_which(name): name for name in read}
    for name in written:
        which = _which("/dev/stdout" if name == "-" else name)
        if which is not None and which in known:
            other = "" if str(known[which]) == str(name) else f", as {known[which]}"
            raise ConfigError(f"{name}: is read or written already{other}; name another file")
        known[which] = name


def _files(names: Iterable[str | Path]) -> Iterator[Path]:
    for path in map(Path, names):
        yield from path.iterdir() if path.is_dir() else [path]


def _which(name: str | Path) -> object:
    """What tells a file from all others, however it is named; None if nothing in it can be lost."""
    try:
        status = Path(name).stat()
    except OSError:  # it is not there yet
        return os.path.realpath(name)
    return (status.st_dev, status.st_ino) if stat.S_ISREG(status.st_mode) else None


def _opened(part: Path) -> int:
    """Open a new file for writing, without its name if that can be had later."""
    if hasattr(os, "O_TMPFILE") and FILES_OPEN.exists():
        with suppress(OSError):  # not on NFS or FAT; the other way says what else is wrong
            return os.open(part.parent, os.O_TMPFILE | os.O_WRONLY, 0o666)
    return os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)


def _give_name(file: int, part: Path) -> None:
    """Name an open file, if it has no name yet: open(2) tells how."""
    if os.fstat(file).st_nlink == 0:
        # Only with a folder to begin at, which an absolute path ignores, are links followed.
        os.link(FILES_OPEN / str(file), part, src_dir_fd=file)


def _like_the_old(target: Path, part: int) -> None:
    """Give an open file the permissions of the old one, and refuse to replace a protected one."""
    if target.exists():
        if not os.access(target, os.W_OK, effective_ids=True):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(target))
        os.fchmod(part, stat.S_IMODE(target.stat().st_mode))
