"""Writes the matrix of promises into docs/promises.md; `make promises` calls it.

The cells are what `tests/promises` runs; the times are measured now, in stepped time.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tests"))


def replaced(text: str, name: str, lines: Iterable[str]) -> str:
    """Put lines in a document between the marks of a name."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    found = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    new = "\n".join([begin, *lines, end])
    changed, times = found.subn(lambda _: new, text)
    if times != 1:
        raise SystemExit(f"the marks of {name} are not there once")
    return changed


def main() -> None:
    """Write the tables."""
    from promises import tables

    path = ROOT / "docs" / "promises.md"
    text = path.read_text(encoding="utf-8")
    text = replaced(text, "doors", tables.doors_table())
    text = replaced(text, "exits", tables.exits_table())
    path.write_text(replaced(text, "times", tables.times()), encoding="utf-8")


if __name__ == "__main__":
    main()
