"""How the lines of a manifest are written: fields with a tab between them. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

MANIFEST_NAME = "manifest.tsv"
"""What the list of a folder of recordings is called."""


class ManifestLine(NamedTuple):
    """A line of a manifest: where it stands, from 1 on, and its fields."""

    number: int
    fields: list[str]


def parse_lines(text: str) -> list[ManifestLine]:
    """Part the text of a manifest into its lines; empty ones are left out.

    Args:
        text: as an editor may have left it: with carriage returns, or no last end of a line.

    Returns:
        The lines in their order, the first of which names the columns.
    """
    numbered = enumerate(text.split("\n"), start=1)
    return [
        ManifestLine(number, line.rstrip("\r").split("\t"))
        for number, line in numbered
        if line.strip()
    ]


def parse_records(text: str) -> list[dict[str, str]]:
    """Part the text of a manifest into its rows, each as its fields by the names of the columns."""
    header, *rows = parse_lines(text)
    return [dict(zip(header.fields, row.fields, strict=True)) for row in rows]


def join_lines(rows: Iterable[Sequence[str]]) -> str:
    """Write rows as the text of a manifest, the end of the last line included."""
    return "".join("\t".join(fields) + "\n" for fields in rows)
