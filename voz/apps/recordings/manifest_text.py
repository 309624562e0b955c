"""The text of a manifest: lines of fields with tabs between them. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

MANIFEST_NAME = "manifest.tsv"


class ManifestLine(NamedTuple):
    """A line of a manifest: its number, from 1, and its fields."""

    number: int
    fields: list[str]


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
