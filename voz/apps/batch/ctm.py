"""Words with their times as NIST's `sclite` reads them: CTM, a line for each word.

The format is in the manual of SCTK, https://github.com/usnistgov/SCTK/blob/master/doc/infmts.htm.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

COMMENT = ";;"
CHANNEL = "1"


def ctm_lines(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield a line for each word of a row; those of refused utterances are comments.

    Args:
        record: the fields of a row by their columns.
    """
    if record["error"]:
        yield f"{COMMENT} {_one_line(record['error'])}"
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


def _one_line(text: str) -> str:
    return " ".join(text.split())
