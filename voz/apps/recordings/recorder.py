"""Records what is heard: the sound of utterances, in a folder with a manifest."""

from __future__ import annotations

import io
import queue
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
import soundfile

from voz.apps.recordings.manifest import MANIFEST_NAME, Kind, join_lines, parse_lines
from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError
from voz.events import Utterance, to_json
from voz.files import append_line, atomic_write

EXCERPT_MARGIN = int(0.3 * SAMPLE_RATE)
"""Samples on either side, with which the end-pointer finds the same speech in it."""

LONGEST_KEPT = 30 * SAMPLE_RATE
"""Samples: an utterance of 10 s may be settled only after the next one of 10 s."""


@dataclass(frozen=True)
class Excerpt:
    """What was heard, and its sound."""

    utterance: Utterance
    samples: Samples


class RecentSound:
    """Takes a stream block by block, and returns the sound of its utterances."""

    def __init__(self) -> None:
        self._blocks: deque[Samples] = deque()
        self._begin = 0  # of `_blocks` in the stream, in samples
        self._end = 0
        self._open: list[tuple[int, int, Utterance]] = []  # their sound is not complete yet

    def feed(self, block: Samples) -> Iterator[Excerpt]:
        """Take the next samples, 16 kHz; yields marked utterances whose sound is complete."""
        self._blocks.append(block)
        self._end += len(block)
        while self._end - self._begin - len(self._blocks[0]) >= LONGEST_KEPT:
            self._begin += len(self._blocks.popleft())
        yield from self._cut([piece for piece in self._open if piece[1] <= self._end])

    def mark(self, start: float, end: float, utterance: Utterance) -> None:
        """Ask for the sound of an utterance from `start` to `end` of the stream, s."""
        first, last = round(start * SAMPLE_RATE), round(end * SAMPLE_RATE)
        self._open.append((first - EXCERPT_MARGIN, last + EXCERPT_MARGIN, utterance))

    def finish(self) -> Iterator[Excerpt]:
        """End the stream; yields what is still open, with the sound that there is."""
        yield from self._cut(list(self._open))

    def _cut(self, pieces: list[tuple[int, int, Utterance]]) -> Iterator[Excerpt]:
        for piece in pieces:
            self._open.remove(piece)
            first, last, utterance = piece
            samples = np.concatenate(self._blocks) if self._blocks else np.empty(0, np.int16)
            begin, end = max(0, first - self._begin), max(0, last - self._begin)
            if len(samples[begin:end]):
                yield Excerpt(utterance, samples[begin:end].copy())


FOLDER_COLUMNS = ("file", "text", "speaker", "kind", "event")
DEFAULT_SPEAKER = "user"

FREED_SHARE = 0.05
"""Share of the limit that is freed at a time, so that the manifest is seldom rewritten."""


class RecordingFolder:
    """Recordings with a manifest and a limit on their size, to which more are added.

    A user may edit the manifest meanwhile: it is read again before each change.
    """

    def __init__(self, path: Path, limit: float) -> None:
        """Open or make a folder; beyond the limit, bytes, the oldest recordings are removed.

        Raises:
            AudioError: its manifest is something else.
            OSError: it cannot be written.
        """
        self._path = path
        self._limit = limit
        self._manifest = path / MANIFEST_NAME
        path.mkdir(parents=True, exist_ok=True)
        rows = self._rows() if self._manifest.exists() else []
        self._size = sum(self._size_of(row) for row in rows if _is_recorded(row))
        self._write(rows)

    def add(self, excerpt: Excerpt) -> str:
        """Save a recording; returns the name of its file, or raises OSError."""
        utterance = excerpt.utterance
        kind = "command" if utterance.accepted else "near-miss"
        fields = [utterance.text, DEFAULT_SPEAKER, kind, to_json(utterance)]
        path = save_recording(excerpt.samples, self._path, FOLDER_COLUMNS, fields)
        self._size += path.stat().st_size
        if self._size > self._limit:
            self._make_room()
        return path.name

    def correct(self, name: str, text: str, kind: Kind) -> None:
        """Write into the manifest what was really said; AudioError if the recording is gone."""
        rows = self._rows()
        row = next((row for row in rows if _is_recorded(row) and row[0] == name), None)
        if row is None:
            raise AudioError(f"{self._path / name}: was removed; mark another one")
        row[FOLDER_COLUMNS.index("text")], row[FOLDER_COLUMNS.index("kind")] = text, kind
        self._write(rows)

    def _make_room(self) -> None:
        rows = self._rows()
        for oldest in [row for row in rows if _is_recorded(row)]:
            if self._size <= self._limit * (1 - FREED_SHARE):
                break
            self._size -= self._size_of(oldest)
            (self._path / oldest[0]).unlink(missing_ok=True)
            rows.remove(oldest)
        self._write(rows)

    def _rows(self) -> list[list[str]]:
        text = self._manifest.read_text(encoding="utf-8-sig")
        rows = [row.fields for row in parse_lines(text)]
        if rows and tuple(rows.pop(0)) != FOLDER_COLUMNS:
            raise AudioError(
                f"{self._manifest}: is not a manifest of recordings; name another folder"
            )
        is_cut_short = rows and len(rows[-1]) < len(FOLDER_COLUMNS)
        if is_cut_short and not text.endswith("\n"):  # by a power failure
            rows.pop()
        return rows

    def _write(self, rows: list[list[str]]) -> None:
        with atomic_write(self._manifest) as manifest:
            manifest.write(join_lines([FOLDER_COLUMNS, *rows]))

    def _size_of(self, row: list[str]) -> int:
        path = self._path / row[0]
        return path.stat().st_size if path.is_file() else 0


def _is_recorded(row: list[str]) -> bool:
    """Whether voz wrote a row; a user's own rows stay, with their files."""
    return len(row) == len(FOLDER_COLUMNS) and row[-1] != "" and Path(row[0]).name == row[0] != ""


def save_recording(
    samples: Samples, folder: Path, header: Sequence[str], fields: Sequence[str]
) -> Path:
    """Write a recording, then its line in the manifest, so that a listed file always exists.

    `header` is for a new manifest; `fields` are all but its first column, the name of the file.

    Raises:
        OSError: it cannot be written.
    """
    flac = io.BytesIO()
    soundfile.write(flac, samples, SAMPLE_RATE, format="FLAC")
    path = _new_path(folder)
    with atomic_write(path, "wb") as file:
        file.write(flac.getvalue())
    manifest = folder / MANIFEST_NAME
    lines = [] if manifest.exists() else [header]
    lines.append([path.name, *fields])
    append_line(manifest, join_lines(lines).removesuffix("\n"))
    return path


def _new_path(folder: Path) -> Path:
    """Return a path that was never used: the name of a deleted file may be in the manifest."""
    name = f"{datetime.now():%Y%m%d-%H%M%S-%f}"
    paths = (folder / f"{name}{more}.flac" for more in ("", *"abcdefghij"))
    return next(path for path in paths if not path.exists())


BYTES_PER_GIGABYTE = 1_000_000_000

MOST_UNSAVED = 20
"""Jobs that wait for a slow disk: utterances and corrections."""

RECORDER_CLOSE_TIMEOUT = 2.0
"""To write what is waiting when the run ends, s."""

MOST_UNREAD_SAVED = 100
"""Entries in `Recorder.kept` that nobody has read yet."""


class SavedRecording(NamedTuple):
    """A recording that was written: where its utterance begins in the run, s, and its file."""

    start: float
    file: str


_Job: TypeAlias = Callable[[RecordingFolder], None]


class Recorder:
    """Writes recordings on a thread of its own, so that the disk delays nobody.

    A failure of the disk is reported once, and the run goes on. Use it in a `with` block.
    """

    def __init__(self, folder: Path, gigabytes: float, warn: Callable[[str], None]) -> None:
        """Prepare to record, with a limit on the size of all recordings in the folder."""
        self.folder = folder  # where the recordings go
        # What was written; whoever reads it removes it.
        self.kept: deque[SavedRecording] = deque(maxlen=MOST_UNREAD_SAVED)
        self._said = f"what is said is recorded in {folder}"
        self._limit = gigabytes * BYTES_PER_GIGABYTE
        self._warn = warn
        self._recent = RecentSound()
        self._waiting: queue.Queue[_Job | None] = queue.Queue(MOST_UNSAVED)
        self._late = False
        self._thread = threading.Thread(target=self._work, name="voz-recorder", daemon=True)

    @property
    def note(self) -> str:
        """The notice that is shown while it records; empty once it has failed."""
        return self._said if self._thread.is_alive() else ""

    def feed(self, block: Samples) -> None:
        """Take the next samples of the microphone."""
        for excerpt in self._recent.feed(block):
            self._put(excerpt)

    def mark(self, utterance: Utterance, begun: float) -> None:
        """Record an utterance of a stream that began at this time of the run, s."""
        self._recent.mark(utterance.start - begun, utterance.end - begun, utterance)

    def end_stream(self) -> None:
        """End a stream; another one follows."""
        for excerpt in self._recent.finish():
            self._put(excerpt)
        self._recent = RecentSound()

    def correct(self, file: str, text: str, kind: Kind) -> Future[None]:
        """Write into the manifest what was really said; the future may raise AudioError or OSError.

        Raises:
            AudioError: recording has failed, or the disk is too slow.
        """
        done: Future[None] = Future()

        def job(folder: RecordingFolder) -> None:
            try:
                folder.correct(file, text, kind)
                done.set_result(None)
            except (AudioError, OSError, UnicodeDecodeError) as error:
                done.set_exception(error)

        if not self._thread.is_alive():
            raise AudioError(f"{self.folder}: nothing is recorded any more; start `voz run` anew")
        try:
            self._waiting.put_nowait(job)
        except queue.Full:
            raise AudioError(f"{self.folder}: the disk is too slow; try again") from None
        return done

    def __enter__(self) -> Recorder:
        self._warn(self._said)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        if not self._thread.is_alive():
            return
        try:
            self._waiting.put(None, timeout=RECORDER_CLOSE_TIMEOUT)
        except queue.Full:
            return
        self._thread.join(RECORDER_CLOSE_TIMEOUT)

    def _put(self, excerpt: Excerpt) -> None:
        try:
            self._waiting.put_nowait(lambda folder: self._keep(excerpt, folder))
        except queue.Full:
            if not self._late and self._thread.is_alive():
                self._late = True
                self._warn(f"{self.folder}: the disk is too slow; not everything is recorded")

    def _keep(self, excerpt: Excerpt, folder: RecordingFolder) -> None:
        self.kept.append(SavedRecording(excerpt.utterance.start, folder.add(excerpt)))

    def _work(self) -> None:
        try:
            folder = RecordingFolder(self.folder, self._limit)
            while (job := self._waiting.get()) is not None:
                job(folder)
        except AudioError as error:
            self._warn(f"nothing is recorded: {error}")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "no UTF-8 text"
            self._warn(f"nothing more is recorded: {self.folder}: cannot be written ({reason})")
