"""The distances between English phones, as `tools/fit_confusion.py` measured them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

DISTANCES_FILE = Path(__file__).with_name("phone_distances.tsv")


@dataclass(frozen=True)
class PhoneDistances:
    """The distances between phones in an acoustic model."""

    frames: Mapping[str, float]  # how many frames of 10 ms a phone lasts
    # What a frame of the first phone loses, in nats, if it is taken for the second.
    apart: Mapping[str, Mapping[str, float]]


@cache
def read_distances(path: Path = DISTANCES_FILE) -> PhoneDistances:
    """Read the table of phone distances that comes with voz."""
    lines = path.read_text(encoding="utf-8").splitlines()
    header, *rows = (line.split("\t") for line in lines if not line.startswith("#"))
    frames = {phone: float(length) for phone, length, *_ in rows}
    apart = {row[0]: dict(zip(header[2:], map(float, row[2:]), strict=True)) for row in rows}
    return PhoneDistances(frames, apart)
