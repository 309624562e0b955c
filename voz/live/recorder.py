"""Keeps what is heard on disk, for a test set of one's own: recordings, and a manifest of them."""

from __future__ import annotations

import io
import queue
import threading
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from types import TracebackType

import soundfile

from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError
from voz.events import Utterance, to_json
from voz.live.tape import Piece, Tape

MANIFEST = "manifest.tsv"
HEADER = ("file", "text", "speaker", "kind", "event")
SPEAKER = "user"

GIGABYTE = 1_000_000_000

TO_SPARE = 0.05
"""Part of the limit that is made free when it is reached: the manifest is seldom written anew."""

MOST_WAITING = 20
"""Utterances that wait for a slow disk."""

CLOSING_TIME = 2.0
"""For what is still to be written, s."""


class Folder:
    """Recordings with a manifest, to which more are added; with a limit on what they take.

    A user may correct the manifest meanwhile: it is read anew whenever it is changed.
    """

    def __init__(self, path: Path, limit: float) -> None:
        """Open a folder, or make it.

        Args:
            path: of the folder.
            limit: what the recordings may take, bytes; beyond it the oldest are removed.

        Raises:
            AudioError: its manifest is another one.
            OSError: it cannot be written.
        """
        self._path = path
        self._limit = limit
        self._manifest = path / MANIFEST
        path.mkdir(parents=True, exist_ok=True)
        if not self._manifest.exists():
            self._write([])
        rows = self._rows()
        self._size = sum(self._size_of(row) for row in rows if _is_recorded(row))
        self._write(rows)

    def add(self, piece: Piece) -> None:
        """Keep a recording; raises OSError if it cannot be written."""
        flac = io.BytesIO()
        soundfile.write(flac, piece.samples, SAMPLE_RATE, format="FLAC")
        path = self._new_path()
        path.write_bytes(flac.getvalue())
        self._size += len(flac.getvalue())
        utterance = piece.utterance
        kind = "command" if utterance.accepted else "near-miss"
        row = [path.name, utterance.text, SPEAKER, kind, to_json(utterance)]
        with self._manifest.open("a", encoding="utf-8") as manifest:
            manifest.write("\t".join(row) + "\n")
        if self._size > self._limit:
            self._make_room()

    def _make_room(self) -> None:
        rows = self._rows()
        for oldest in [row for row in rows if _is_recorded(row)]:
            if self._size <= self._limit * (1 - TO_SPARE):
                break
            self._size -= self._size_of(oldest)
            (self._path / oldest[0]).unlink(missing_ok=True)
            rows.remove(oldest)
        self._write(rows)

    def _rows(self) -> list[list[str]]:
        *lines, unfinished = self._manifest.read_text(encoding="utf-8-sig").split("\n")
        header, *rows = [line.rstrip("\r").split("\t") for line in [*lines, unfinished] if line]
        if tuple(header) != HEADER:
            raise AudioError(f"{self._manifest}: is not one of recordings; name another folder")
        if unfinished and not _is_recorded(rows[-1]):  # the power failed
            rows.pop()
        return rows

    def _write(self, rows: list[list[str]]) -> None:
        unfinished = self._manifest.with_suffix(".part")
        lines = ["\t".join(row) + "\n" for row in [list(HEADER), *rows]]
        unfinished.write_text("".join(lines), encoding="utf-8")
        unfinished.replace(self._manifest)

    def _size_of(self, row: list[str]) -> int:
        path = self._path / row[0]
        return path.stat().st_size if path.is_file() else 0

    def _new_path(self) -> Path:
        name = f"{datetime.now():%Y%m%d-%H%M%S-%f}"
        paths = (self._path / f"{name}{more}.flac" for more in ("", *"abcdefghij"))
        return next(path for path in paths if not path.exists())


def _is_recorded(row: list[str]) -> bool:
    """Whether a row is not a user's own; those stay, with their files."""
    return len(row) == len(HEADER) and row[-1] != "" and Path(row[0]).name == row[0] != ""


class Recorder:
    """Writes recordings on a thread of its own, so that nobody waits for the disk.

    Whatever is wrong with the disk is told once, and the run goes on. Use it in a `with` block.
    """

    def __init__(self, folder: Path, gigabytes: float, warn: Callable[[str], None]) -> None:
        """Prepare to record.

        Args:
            folder: where to.
            gigabytes: what all recordings in it may take.
            warn: called with what is wrong, and with what a user must know.
        """
        self._folder = folder
        self._said = f"what is said is recorded in {folder}"
        self._limit = gigabytes * GIGABYTE
        self._warn = warn
        self._tape = Tape()
        self._waiting: queue.Queue[Piece | None] = queue.Queue(MOST_WAITING)
        self._late = False
        self._thread = threading.Thread(target=self._work, name="voz-recorder", daemon=True)

    @property
    def note(self) -> str:
        """What is to be seen all the time; nothing if it does not record any more."""
        return self._said if self._thread.is_alive() else ""

    def feed(self, block: Samples) -> None:
        """Take what the microphone gave."""
        for piece in self._tape.feed(block):
            self._put(piece)

    def mark(self, utterance: Utterance, begun: float) -> None:
        """Keep what was heard.

        Args:
            utterance: with the times of the run.
            begun: when the stream began in the run, s.
        """
        self._tape.mark(utterance.start - begun, utterance.end - begun, utterance)

    def end_stream(self) -> None:
        """Note that what follows is another stream."""
        for piece in self._tape.finish():
            self._put(piece)
        self._tape = Tape()

    def __enter__(self) -> Recorder:
        self._warn(self._said)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if not self._thread.is_alive():
            return
        try:
            self._waiting.put(None, timeout=CLOSING_TIME)
        except queue.Full:
            return
        self._thread.join(CLOSING_TIME)

    def _put(self, piece: Piece) -> None:
        try:
            self._waiting.put_nowait(piece)
        except queue.Full:
            if not self._late and self._thread.is_alive():
                self._late = True
                self._warn(f"{self._folder}: the disk is too slow; not everything is recorded")

    def _work(self) -> None:
        try:
            folder = Folder(self._folder, self._limit)
            while (piece := self._waiting.get()) is not None:
                folder.add(piece)
        except AudioError as error:
            self._warn(f"nothing is recorded: {error}")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "no UTF-8 text"
            self._warn(f"nothing more is recorded: {self._folder}: cannot be written ({reason})")
