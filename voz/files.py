"""Writes files so that nothing is lost: whole or not at all, a line or none of it."""

from __future__ import annotations

import errno
import os
import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any


@contextmanager
def replaced(path: Path, mode: str = "w") -> Iterator[IO[Any]]:
    """Write a file anew; until it is complete, and if it never is, the old one stays.

    Args:
        path: of the file; if it is a link, what it points to is replaced.
        mode: `w` for text, in UTF-8, or `wb` for bytes.

    Yields:
        A file beside `path`, which takes its place when the block ends without an exception.
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
        with part.open(mode.replace("w", "x"), **how) as file:
            _like_the_old(target, part)
            yield file
            file.flush()
            os.fsync(file.fileno())  # robots lose their power
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


def _like_the_old(target: Path, part: Path) -> None:
    """Give the part file the permissions of the old one, and refuse to replace a protected one."""
    if target.exists():
        if not os.access(target, os.W_OK, effective_ids=True):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(target))
        shutil.copymode(target, part)
