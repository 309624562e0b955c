"""Keeps recordings in a folder with a list of them. An edge: it writes files."""

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
    """Write a recording, then its line: whatever interrupts it, what is listed is there.

    Args:
        samples: the recording.
        folder: where it is kept, beside whatever is there.
        header: the names of the list's columns, if there is no list yet.
        fields: what stands in them, but for the first, which is the name of the file.

    Returns:
        The file.

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
    """Name a file that never was: a name that was deleted may still be in a list."""
    name = f"{datetime.now():%Y%m%d-%H%M%S-%f}"
    paths = (folder / f"{name}{more}.flac" for more in ("", *"abcdefghij"))
    return next(path for path in paths if not path.exists())
