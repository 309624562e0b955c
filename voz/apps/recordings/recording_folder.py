"""A folder of recordings with a manifest, as the evaluation reads it."""

from __future__ import annotations

import io
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import soundfile

from voz.apps.recordings.manifest import MANIFEST_NAME, Kind, join_lines, parse_lines
from voz.apps.recordings.recent_sound import Excerpt
from voz.audio import SAMPLE_RATE, Samples
from voz.errors import AudioError
from voz.events import to_json
from voz.files import append_line, atomic_write

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
