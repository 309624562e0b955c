"""Words with their times: CTM for NIST's `sclite`, and a TextGrid for Praat.

https://github.com/usnistgov/SCTK/blob/master/doc/infmts.htm
https://www.fon.hum.uva.nl/praat/manual/TextGrid_file_formats.html
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from voz.apps.batch.locations import file_name_for
from voz.apps.batch.outcomes import Outcome, UtteranceRow
from voz.events import explain
from voz.files import atomic_write, os_errors_as_config_error

if TYPE_CHECKING:
    from voz.apps.batch.batch_decoder import Finished


COMMENT = ";;"
CHANNEL = "1"

TEXT_GRID_ENDING = ".TextGrid"


def ctm_lines(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield a line for each word of a row, by its columns; for a refused one a comment."""
    if record["error"]:
        yield f"{COMMENT} {' '.join(record['error'].split())}"
    before = "" if record["accepted"] else f"{COMMENT} "
    for each in record["words"] or ():
        begin = max(0.0, each["start"])
        times = f"{begin:.3f} {max(0.0, each['end'] - begin):.3f}"
        name = ctm_name(record["file"])
        yield f"{before}{name} {CHANNEL} {times} {each['word']} {record['confidence']:.3f}"


def ctm_name(file: str) -> str:
    """A recording as a CTM names it: white space, which ends a name there, is escaped."""
    escaped = "".join(map(_escaped, file))
    return escaped.replace(";", "%3B", 1) if escaped.startswith(";") else escaped


def _escaped(character: str) -> str:
    if character != "%" and character.isprintable() and not character.isspace():
        return character
    return "".join(f"%{byte:02X}" for byte in character.encode("utf-8", "backslashreplace"))


class Interval(NamedTuple):
    """A stretch of a tier, s, and its label."""

    start: float
    end: float
    text: str


def with_text_grids(finished: Iterable[Finished], folder: Path) -> Iterator[Finished]:
    """Write the TextGrid of each recording that was heard, named after it, as it comes.

    Raises:
        ConfigError: it cannot be written.
    """
    for each in finished:
        if text := text_grid(each.outcome):
            path = folder / f"{file_name_for(each.outcome.rows[0].file)}{TEXT_GRID_ENDING}"
            with os_errors_as_config_error(path), atomic_write(path) as file:
                file.write(text)
        yield each


def text_grid(outcome: Outcome) -> str:
    """Write an outcome as a TextGrid; empty if nothing was heard of the recording."""
    heard = [row for row in outcome.rows if isinstance(row, UtteranceRow)]
    tiers = {
        "words": [Interval(w.start, w.end, w.word) for row in heard for w in row.words],
        "accepted": [Interval(h.start, h.end, h.text) for h in heard if h.accepted],
        "refused": [Interval(h.start, h.end, _refused(h)) for h in heard if not h.accepted],
    }
    end = max([outcome.seconds, *(each.end for tier in tiers.values() for each in tier)])
    if end <= 0:
        return ""
    lines = [
        'File type = "ooTextFile"',
        'Object class = "TextGrid"',
        "",
        "xmin = 0",
        f"xmax = {end}",
        "tiers? <exists>",
        f"size = {len(tiers)}",
        "item []:",
    ]
    for number, (name, tier) in enumerate(tiers.items(), start=1):
        lines += [f"    item [{number}]:", *_tier_lines(name, list(_filled(tier, end)), end)]
    return "".join(f"{line}\n" for line in lines)


def _tier_lines(name: str, intervals: Sequence[Interval], end: float) -> Iterator[str]:
    yield '        class = "IntervalTier"'
    yield f"        name = {_quoted(name)}"
    yield "        xmin = 0"
    yield f"        xmax = {end}"
    yield f"        intervals: size = {len(intervals)}"
    for number, each in enumerate(intervals, start=1):
        yield f"        intervals [{number}]:"
        yield f"            xmin = {each.start}"
        yield f"            xmax = {each.end}"
        yield f"            text = {_quoted(each.text)}"


def _filled(tier: Iterable[Interval], end: float) -> Iterator[Interval]:
    """A tier from 0 to its end without gaps and overlaps, as Praat needs it."""
    now = 0.0
    for start, stop, text in tier:
        start = max(start, now)
        if stop <= start:
            continue
        if start > now:
            yield Interval(now, start, "")
        yield Interval(start, stop, text)
        now = stop
    if now < end:
        yield Interval(now, end, "")


def _refused(row: UtteranceRow) -> str:
    return row.text or f"({explain(row.reason or 'not_a_command', row.between)})"


def _quoted(text: str) -> str:
    doubled = text.replace('"', '""')
    return f'"{doubled}"'
