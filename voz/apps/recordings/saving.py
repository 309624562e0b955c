"""Saves recordings in a folder with a manifest. An edge: it writes files."""

from __future__ import annotations

import io
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import soundfile

from voz.apps.recordings.manifest_text import MANIFEST_NAME, join_lines
from voz.audio import SAMPLE_RATE, Samples
from voz.files import append_line, atomic_write


def save_recording(
    samples: Samples, folder: Path, header: Sequence[str], fields: Sequence[str]
) -> Path:
    """Write a recording, then its line in the manifest, so that a listed file always exists.

    Args:
        samples: 16 kHz.
        folder: where it is saved.
        header: the names of the columns, for a new manifest.
        fields: all columns but the first, which is the name of the file.

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
