"""Bags on the disk that can be read at any time, even after a full disk or `kill -9`.

rosbags writes the end, which makes a bag readable, only when it is closed. Here the end is written
again and again: each new end replaces the one before, behind the messages that were added.
"""

from __future__ import annotations

import copy
import errno
import os
import shutil
import sqlite3
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

METADATA_VERSION: Literal[8] = 8
"""The oldest that rosbags writes: most readers know it."""

EMPTY_DATABASE = 2**16
"""Room for a database without messages, bytes."""


class BagFile(ABC):
    """A bag that a writer of rosbags writes."""

    writer: Any
    topics: dict[str, Any]

    def write(self, topic: str, stamp: int, data: Any) -> None:
        """Add a serialized message with its time, ns; raises what `save` does."""
        self.writer.write(self.topics[topic], stamp, data)

    @abstractmethod
    def save(self) -> None:
        """Write the whole bag to the disk; after an OSError or sqlite3.Error it is as before."""

    @abstractmethod
    def close(self) -> None:
        """Close it, without what was not saved."""


def open_bag(path: Path, topics: Mapping[str, str], types: Typestore) -> BagFile:
    """Make a new bag of the kind that its ending names, with the type of each topic.

    Raises:
        OSError: nothing is left of the bag; as with sqlite3.Error.
    """
    kind = {".bag": _Ros1, ".mcap": _Mcap}.get(path.suffix, _Database)
    try:
        bag = kind(path)
        with ExitStack() as undone:
            undone.callback(bag.close)
            bag.topics = {
                topic: bag.writer.add_connection(topic, message, typestore=types)
                for topic, message in topics.items()
            }
            bag.save()
            undone.pop_all()
    except (OSError, sqlite3.Error):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
        raise
    return bag


class _Pieces:
    """A file for a writer of rosbags: keeps in memory what is written, and at which offset."""

    def __init__(self, at: int) -> None:
        self.begin(at)

    def begin(self, at: int) -> None:
        self.pieces = [(at, bytearray())]

    def tell(self) -> int:
        at, data = self.pieces[-1]
        return at + len(data)

    def seek(self, at: int) -> None:
        self.pieces.append((at, bytearray()))

    def write(self, data: bytes) -> None:
        self.pieces[-1][1].extend(data)

    def close(self) -> None:
        """Do nothing: the pieces are still to be written."""


class _OneFile(BagFile):
    """A bag that is one file, written from its beginning to its end."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("r+b", buffering=0)
        self._added = _Pieces(path.stat().st_size)
        self._end: list[tuple[int, bytearray]] = []

    def save(self) -> None:
        self._finish_chunk()
        end = _Pieces(self._added.tell())
        self._write_end(end)
        try:
            self._put([*self._added.pieces, *end.pieces])
        except OSError:
            self._put(self._end)  # it fitted before
            raise
        self._end = end.pieces
        self._added.begin(self._end[0][0])

    def close(self) -> None:
        self._file.close()

    def _put(self, pieces: list[tuple[int, bytearray]]) -> None:
        for at, data in pieces:
            self._file.seek(at)
            if self._file.write(data) < len(data):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if pieces:
            self._file.truncate(max(at + len(data) for at, data in pieces))

    @abstractmethod
    def _finish_chunk(self) -> None:
        """Let the writer add what it buffers."""

    @abstractmethod
    def _write_end(self, end: _Pieces) -> None:
        """Let a copy of the writer write its end there."""


class _Ros1(_OneFile):
    def __init__(self, path: Path) -> None:
        from rosbags.rosbag1 import Writer

        self.writer = Writer(path)
        try:
            self.writer.open()
        finally:
            if self.writer.bio:
                self.writer.bio.close()
        super().__init__(path)
        self.writer.bio = self._added

    def _finish_chunk(self) -> None:
        chunk = self.writer.chunks[-1]
        if chunk.connections:  # one without messages would have time 0
            self.writer.write_chunk(chunk)

    def _write_end(self, end: _Pieces) -> None:
        ending = copy.copy(self.writer)
        ending.chunks = [*ending.chunks[:-1], copy.deepcopy(ending.chunks[-1])]
        ending.bio = end
        ending.close()


class _Mcap(_OneFile):
    def __init__(self, path: Path) -> None:
        from rosbags.rosbag2 import StoragePlugin

        with tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent) as around:
            self.writer = _writer(Path(around) / path.stem, StoragePlugin.MCAP)
            self.writer.storage.bio.close()
            self.writer.storage.path.replace(path)
        super().__init__(path)
        self.writer.storage.bio = self._added

    def _finish_chunk(self) -> None:
        if self.writer.storage.chunk.msgs:  # as in bags of ROS 1
            self.writer.storage.close_chunk()

    def _write_end(self, end: _Pieces) -> None:
        ending = copy.copy(self.writer)
        ending.storage = copy.copy(self.writer.storage)
        ending.storage.chunks = [*ending.storage.chunks]
        ending.storage.bio = end
        ending.metapath = _Nowhere()
        ending.close()


class _Database(BagFile):
    """An SQLite database: a file, or in a folder with a description beside it."""

    def __init__(self, path: Path) -> None:
        from rosbags.rosbag2 import StoragePlugin

        # On a full disk rosbags would leave the database open.
        with tempfile.TemporaryFile(dir=path.parent) as room:
            room.write(bytes(EMPTY_DATABASE))
        self._metapath: Any = path / "metadata.yaml"
        if not path.suffix:
            self.writer = _writer(path, StoragePlugin.SQLITE3)
            return
        self._metapath = _Nowhere()
        with tempfile.TemporaryDirectory(prefix=f".{path.name}.", dir=path.parent) as around:
            self.writer = _writer(Path(around) / path.stem, StoragePlugin.SQLITE3)
            storage = self.writer.storage
            storage.conn.close()
            storage.path.replace(path)
        storage.conn = sqlite3.connect(path)
        storage.cursor = storage.conn.cursor()

    def save(self) -> None:
        storage = self.writer.storage

        def keep(version: int, metadata: str) -> None:
            entry = "INSERT OR REPLACE INTO metadata VALUES (1, ?, ?)"
            storage.conn.execute(entry, (version, metadata))
            storage.conn.commit()

        ending = copy.copy(self.writer)
        ending.storage = SimpleNamespace(path=storage.path, close=keep)
        ending.metapath = self._metapath
        ending.close()

    def close(self) -> None:
        self.writer.storage.conn.close()


class _Nowhere:
    """The path of a description that is not written: a bag in one file needs none."""

    def with_suffix(self, _: str) -> _Nowhere:
        return self

    def write_text(self, *_: str) -> None:
        """Do nothing, as `replace`."""

    def replace(self, _: object) -> None: ...


def _writer(folder: Path, storage: Any) -> Any:
    from rosbags.rosbag2 import Writer

    writer = Writer(folder, version=METADATA_VERSION, storage_plugin=storage)
    writer.open()
    return writer
