"""Manifests: lists of recordings with what is said in them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Literal, NamedTuple, cast, get_args

import msgspec

from voz.errors import ConfigError
from voz.files import read_text, shown_path
from voz.language.sentences.spelling import normalize

MANIFEST_NAME = "manifest.tsv"

Kind = Literal["command", "near-miss", "talk", "noise", "long"]

BETWEEN_COMMANDS = " | "
"""Separates the commands in the text of a `long` recording."""

REQUIRED_COLUMNS = {
    "file": ("path", "file"),
    "text": ("text",),
    "speaker": ("speaker", "voice"),
    "kind": ("kind",),
}
"""Columns that a manifest must have, with the names they may have."""

MANIFEST_KINDS = {kind: kind for kind in get_args(Kind)} | {"format": "command"}
"""Kinds in manifests, and what they are read as; `format` is a command in an odd file format."""

OPTIONAL_COLUMNS = ("condition", "start", "end")

ALL_CONDITIONS = "all"
"""The condition where a manifest has none."""


class Clip(msgspec.Struct, frozen=True):
    """A recording with a known text, or a stretch of one."""

    set: str  # name of the manifest
    file: str  # path as in the manifest; with `set` the name in reports
    path: Path
    text: str  # lower case; the commands of a `long` one with ` | ` between them
    speaker: str  # the file itself if the manifest has none
    # one `command` or several (`long`); `near-miss`, `talk` and `noise` should move nothing
    kind: Kind
    condition: str  # a group of recordings that is scored by itself
    start: float | None = None  # in a stream, s; None if it is a whole recording
    end: float | None = None  # s


class ManifestLine(NamedTuple):
    """A line of a manifest: its number, from 1, and its fields."""

    number: int
    fields: list[str]


def read_manifest(path: Path, streams: bool = False) -> list[Clip]:
    """Read a manifest: tab-separated values, the names of the columns in the first line.

    Args:
        path: the manifest. Its columns are `path` or `file` (relative to the manifest), `text`,
            `speaker` or `voice`, `kind`, and perhaps `condition`; `start` and `end`, s, where
            something is a stretch of a recording; others are ignored.
        streams: whether stretches are allowed; else each line is a whole recording.

    Returns:
        The recordings and stretches in their order; they need not exist.

    Raises:
        ConfigError: the manifest cannot be read or used; the message has the line.
    """
    (_, header), *rows = _rows(path)
    columns = _columns(header, path)
    clips = []
    for number, fields in rows:
        if len(fields) != len(header):
            raise ConfigError(
                f"{path}:{number}: has {len(fields)} fields and the header {len(header)}; "
                "separate them by one tab each"
            )
        row = {name: fields[index].strip() for name, index in columns.items()}
        clip = _clip(row, path, number)
        if clip.start is not None and not streams:
            raise ConfigError(
                f"{path}:{number}: is a stretch of a recording; only `voz eval` and "
                "`voz fit-confidence` take those, so cut it out into a file of its own"
            )
        clips.append(clip)
    if not clips:
        raise ConfigError(f"{path}: lists no recording; add a line for each below the header")
    return clips


def read_manifests(paths: Iterable[Path], streams: bool = False) -> list[Clip]:
    """Read several manifests, one after the other; see `read_manifest`."""
    return [clip for path in paths for clip in read_manifest(path, streams)]


def set_name(path: Path) -> str:
    """Name a manifest for reports: by its folder if it is called `manifest.tsv`."""
    return shown_path(Path(path.resolve().parent.name if path.stem == "manifest" else path.stem))


def _rows(path: Path) -> list[ManifestLine]:
    """The lines that are not empty; the first is the header."""
    text = read_text(path, ConfigError, "name a manifest, a .tsv file")
    return parse_lines(text) or [ManifestLine(1, [])]


def _columns(header: list[str], path: Path) -> dict[str, int]:
    """Return the index of each column."""
    names = [name.strip() for name in header]
    columns = {}
    for column, allowed in REQUIRED_COLUMNS.items():
        found = [names.index(name) for name in allowed if name in names]
        if not found:
            raise ConfigError(
                f"{path}:1: has no column {' or '.join(allowed)}; "
                "name the columns in the first line, with tabs between them"
            )
        columns[column] = found[0]
    return columns | {name: names.index(name) for name in OPTIONAL_COLUMNS if name in names}


def _clip(row: dict[str, str], path: Path, number: int) -> Clip:
    file, text, kind = row["file"], normalize(row["text"]), row["kind"]
    if kind not in MANIFEST_KINDS:
        kinds = ", ".join(MANIFEST_KINDS)
        raise ConfigError(f'{path}:{number}: invalid kind "{kind}"; use one of {kinds}')
    if not file or "\0" in file:
        raise ConfigError(f"{path}:{number}: names no file; write its path")
    if not text and MANIFEST_KINDS[kind] in ("command", "long"):
        raise ConfigError(f"{path}:{number}: has no text; write the command that is said")
    start, end = _stretch(row, path, number)
    return Clip(
        set=set_name(path),
        file=file,
        path=path.parent / file,
        text=text,
        speaker=row["speaker"] or file,
        kind=cast(Kind, MANIFEST_KINDS[kind]),
        condition=row.get("condition") or ALL_CONDITIONS,
        start=start,
        end=end,
    )


def _stretch(
    row: dict[str, str], path: Path, number: int
) -> tuple[float, float] | tuple[None, None]:
    """Start and end of a stretch, s; None for a whole recording."""
    times = row.get("start", ""), row.get("end", "")
    if times == ("", ""):
        return None, None
    try:
        start, end = map(float, times)
    except ValueError:
        start = end = math.nan
    if not 0 <= start < end < math.inf:
        raise ConfigError(
            f'{path}:{number}: begins at "{times[0]}" and ends at "{times[1]}"; '
            "write both in seconds, the end after the start"
        )
    return start, end


def parse_lines(text: str) -> list[ManifestLine]:
    """Split the text of a manifest into its lines, header first; empty ones are left out.

    Carriage returns, and a last line without an end, are accepted: editors write such.
    """
    numbered = enumerate(text.split("\n"), start=1)
    return [
        ManifestLine(number, line.rstrip("\r").split("\t"))
        for number, line in numbered
        if line.strip()
    ]


def parse_records(text: str) -> list[dict[str, str]]:
    """Split the text of a manifest into its rows, each by the names of the columns."""
    header, *rows = parse_lines(text)
    return [dict(zip(header.fields, row.fields, strict=True)) for row in rows]


def join_lines(rows: Iterable[Sequence[str]]) -> str:
    """Write lines as the text of a manifest."""
    return "".join("\t".join(fields) + "\n" for fields in rows)
